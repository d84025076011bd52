"""The segmenter: a small U-Net of plain convolutions, five resolutions, additive skips.

Input [N, 5, S, S] of R, G, B, A and "has alpha" in 0..1; output [N, 3, S, S] logits of background,
trunk, crown. The work is done at half the side and below, which costs little: edges are sharpened
afterwards, by alpha or by the picture itself. S is a multiple of 32.
"""

import torch
from torch import nn

WIDTHS = (16, 32, 64, 96, 128)


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

    def __init__(self, inputs, outputs):
        super().__init__()
        self.up = nn.ConvTranspose2d(inputs, outputs, 2, 2)
        self.mix = block(outputs, outputs)

    def forward(self, x, skip):
        return self.mix(self.up(x) + skip)


class Segmenter(nn.Module):
    def __init__(self, widths=WIDTHS):
        super().__init__()
        w = widths
        self.stem = block(5, w[0], 2)
        self.level1 = block(w[0], w[0])
        self.level2 = nn.Sequential(block(w[0], w[1], 2), Residual(w[1]))
        self.level3 = nn.Sequential(block(w[1], w[2], 2), Residual(w[2]))
        self.level4 = nn.Sequential(block(w[2], w[3], 2), Residual(w[3]))
        self.level5 = nn.Sequential(block(w[3], w[4], 2), Residual(w[4]))
        self.rise4 = Rise(w[4], w[3])
        self.rise3 = Rise(w[3], w[2])
        self.rise2 = Rise(w[2], w[1])
        self.rise1 = Rise(w[1], w[0])
        self.head = nn.ConvTranspose2d(w[0], 3, 2, 2)

    def forward(self, image):
        one = self.level1(self.stem(image))
        two = self.level2(one)
        three = self.level3(two)
        four = self.level4(three)
        x = self.rise4(self.level5(four), four)
        x = self.rise3(x, three)
        x = self.rise2(x, two)
        return self.head(self.rise1(x, one))


def parameters(net):
    """Number of learned parameters."""
    return sum(p.numel() for p in net.parameters())


def multiplications(net, size):
    """Multiply-adds for one picture of `size`²."""
    total = 0

    def count(module, inputs, output):
        nonlocal total
        if isinstance(module, nn.Conv2d):
            total += output.numel() * module.in_channels * module.kernel_size[0] * module.kernel_size[1]
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
        if isinstance(parent, nn.Sequential) and len(parent) >= 2:
            if isinstance(parent[0], nn.Conv2d) and isinstance(parent[1], nn.BatchNorm2d):
                parent[0] = torch.nn.utils.fusion.fuse_conv_bn_eval(parent[0], parent[1])
                parent[1] = nn.Identity()
    return net
