"""Pictures of the site: small PNG files."""

import io

from PIL import Image


def save(plot, path, width=760):
    """A figure as a PNG of at most `width` pixels and 128 colours; its size in bytes."""
    raw = io.BytesIO()
    plot.savefig(raw, format="png", dpi=120)
    image = Image.open(raw).convert("RGB")
    if image.width > width:
        image = image.resize((width, round(image.height * width / image.width)), Image.Resampling.LANCZOS)
    image.quantize(128, dither=Image.Dither.NONE).save(path, optimize=True)
    return path.stat().st_size
