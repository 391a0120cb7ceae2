"""A trained design to take home: files that other programs read, each checked as it is made.

`export_run` writes one folder: the robot as MJCF (`mjcf`) and URDF (`urdf`), its pieces for a 3D
printer (`printing`), the policy as ONNX and as one Python file (`policies`), and both with the
reward as a Gymnasium package (`environment`). `card` says what all of it is worth. Only `folder`
writes, and only into the folder that was named.
"""

from __future__ import annotations

from robomore.export.export import Exported, export_run
from robomore.export.printing import Piece, Printer

__all__ = ["Exported", "Piece", "Printer", "export_run"]
