"""Pictures that the scripts of this folder make by themselves, without any library."""
import struct
import zlib


def picture(path, side, pixel):
    """A PNG of side x side pixels, without any library: pixel(x, y) gives its channels."""
    channels = len(pixel(0, 0))
    rows = b"".join(b"\0" + bytes(v for x in range(side) for v in pixel(x, y)) for y in range(side))
    chunk = lambda name, body: struct.pack(">I", len(body)) + name + body + struct.pack(">I", zlib.crc32(name + body))
    header = struct.pack(">IIBBBBB", side, side, 8, {1: 0, 3: 2, 4: 6}[channels], 0, 0, 0)
    open(path, "wb").write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows, 1)) + chunk(b"IEND", b""))


def photo_and_mask(folder, side):
    """A round crown of clumps on a blue sky, and its mask."""
    inside = lambda x, y: (x - side / 2) ** 2 + (y - side / 2) ** 2 < (0.45 * side) ** 2
    def leaf(x, y):
        green = 60 + (x // 12 * 71 + y // 12 * 37) % 60 + (x * 7919 + y * 104729 + x * y * 31) % 50
        return (green // 2, green, green // 4) if inside(x, y) else (120, 170, 250)
    picture(folder + "/photo.png", side, leaf)
    picture(folder + "/mask.png", side, lambda x, y: (255 * inside(x, y),))
