"""Reads DDS and KTX2 files back with Pillow and zstandard and compares them with the PNG beside them;
of crowns the OpenEXR faces with the 16-bit and sRGB faces.

    pip install pillow numpy zstandard openexr
    python textures.py FOLDER

BC7 blocks of a KTX2 file are put into a DDS file so that Pillow can read them.
"""
import io
import json
import struct
import sys
from pathlib import Path

import numpy
import zstandard
from PIL import Image


def psnr(a, b):
    mse = numpy.mean((a.astype(float) - b.astype(float)) ** 2)
    return 99.0 if mse == 0 else 10 * numpy.log10(255**2 / mse)


def of_visible(image):
    pixels = numpy.array(image.convert("RGBA"))
    return pixels


def dds_of_bc7(blocks, width, height):
    header = struct.pack("<7I", 124, 0x81007, height, width, len(blocks), 0, 1) + bytes(44)
    header += struct.pack("<2I4s5I", 32, 4, b"DX10", 0, 0, 0, 0, 0) + struct.pack("<5I", 0x1000, 0, 0, 0, 0)
    return b"DDS " + header + struct.pack("<5I", 98, 3, 0, 1, 0) + blocks


def ktx2_levels(data):
    assert data[:12] == b"\xabKTX 20\xbb\r\n\x1a\n"
    (format_, _, width, height, _, _, faces, levels, scheme) = struct.unpack_from("<9I", data, 12)
    assert format_ in (145, 146) and faces == 1 and scheme == 2, (format_, faces, scheme)
    for level in range(levels):
        offset, length, raw = struct.unpack_from("<3Q", data, 80 + 24 * level)
        blocks = zstandard.ZstdDecompressor().decompress(data[offset : offset + length], max_output_size=raw)
        assert len(blocks) == raw
        yield max(1, width >> level), max(1, height >> level), blocks


def faces_psnr(record):
    """The worst agreement of a crown's OpenEXR faces with its PNG faces, if there are any."""
    if not (record.parent / "color_px.exr").exists():
        return 99.0
    import OpenEXR

    longest, worst = json.loads(record.read_text())["radius_max_m"], 99.0
    for face in ("px", "nx", "py", "ny", "pz", "nz"):
        def channels(name):
            return OpenEXR.File(str(record.parent / f"{name}_{face}.exr"), separate_channels=True).channels()
        radii = channels("radius")["Y"].pixels / longest
        wanted = numpy.array(Image.open(record.parent / f"radius_{face}.png")) / 65535
        found = channels("color")
        linear = numpy.stack([found[c].pixels for c in "RGB"], axis=-1)
        srgb = numpy.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
        colors = numpy.array(Image.open(record.parent / f"color_{face}.png").convert("RGB"))
        worst = min(worst, psnr(255 * radii, 255 * wanted), psnr(255 * srgb, colors))
    print(f"{record.parent.name}: OpenEXR faces {worst:.1f} dB")
    return worst


def main(folder):
    worst, count = 99.0, 0
    for png in sorted((folder / "textures").glob("*.png")):
        wanted = of_visible(Image.open(png))
        dds = png.with_suffix(".dds")
        if dds.exists():
            found = of_visible(Image.open(dds))
            worst, count = min(worst, psnr(found, wanted)), count + 1
            print(f"{dds.name}: {psnr(found, wanted):.1f} dB")
        ktx2 = png.with_suffix(".ktx2")
        if ktx2.exists():
            levels = list(ktx2_levels(ktx2.read_bytes()))
            width, height, blocks = levels[0]
            found = of_visible(Image.open(io.BytesIO(dds_of_bc7(blocks, width, height))))
            worst, count = min(worst, psnr(found, wanted)), count + 1
            print(f"{ktx2.name}: {psnr(found, wanted):.1f} dB, {len(levels)} levels, 1x1 last: {levels[-1][:2] == (1, 1)}")
    for record in sorted((folder / "cubemaps").glob("*/crown.json")):
        worst, count = min(worst, faces_psnr(record)), count + 1
    print(f"{count} files, worst {worst:.1f} dB")
    return 0 if count and worst > 28 else 1


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
