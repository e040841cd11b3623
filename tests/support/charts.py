"""What is drawn on a report, read back from its HTML."""

import base64
import json
import re

import numpy as np


def charts_of(html):
    """Return the charts of a report."""
    found = re.findall(r'<script type="application/json">(.*?)</script>', html, flags=re.DOTALL)
    return [json.loads(one) for one in found]


def values(packed):
    """Return the numbers of a line or a map, as they were sent."""
    return np.frombuffer(base64.b64decode(packed["bdata"]), "<f4")
