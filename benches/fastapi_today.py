"""The analytic scallop height as a FastAPI service, which is what a Python user would write otherwise: FastAPI, pydantic, uvicorn with uvloop
and httptools, one process, no access log. It answers with the figures of `/v1/scallop-height` except the check by the envelope.

Started by benches/requests; prints the address on which it listens."""

import math
import socket
from typing import Literal

import uvicorn
from fastapi import FastAPI
from pydantic import BaseModel, Field


class Cutter(BaseModel):
    type: Literal["toroidal"]
    diameter_mm: float = Field(gt=0, le=500)
    corner_radius_mm: float = Field(gt=0)
    teeth: int | None = Field(default=None, ge=1, le=100)


class Contact(BaseModel):
    slope_deg: float = Field(ge=0, le=90)
    feed_angle_deg: float


class Request(BaseModel):
    cutter: Cutter
    contact: Contact
    step_over_mm: float = Field(gt=0)
    feed_per_tooth_mm: float = Field(gt=0)


class Answer(BaseModel):
    model: str
    scallop_height_mm: float
    step_over_height_mm: float
    feed_height_mm: float
    feed_share: float
    effective_radius_mm: float
    transverse_effective_radius_mm: float
    step_over_mm: float
    step_over_xy_mm: float
    warnings: list[str]


app = FastAPI()


@app.post("/v1/scallop-height")
async def scallop_height(request: Request) -> Answer:
    core = request.cutter.diameter_mm / 2 - request.cutter.corner_radius_mm
    corner, slope = request.cutter.corner_radius_mm, math.radians(request.contact.slope_deg)
    alpha = math.radians(request.contact.feed_angle_deg)
    across, along = math.cos(alpha) ** 2, math.sin(alpha) ** 2
    effective = core * across / (math.sin(slope) * (1 - along * math.sin(slope) ** 2)) + corner
    transverse = core * along / (math.sin(slope) * (1 - across * math.sin(slope) ** 2)) + corner
    step_over, feed = request.step_over_mm, request.feed_per_tooth_mm
    step_over_height = effective - math.sqrt(effective**2 - step_over**2 / 4)
    feed_height = transverse - math.sqrt(transverse**2 - feed**2 / 4)
    height = step_over_height + feed_height
    return Answer(
        model="analytic", scallop_height_mm=height, step_over_height_mm=step_over_height, feed_height_mm=feed_height,
        feed_share=feed_height / height, effective_radius_mm=effective, transverse_effective_radius_mm=transverse,
        step_over_mm=step_over, step_over_xy_mm=step_over * math.sqrt(1 - math.sin(slope) ** 2 * along), warnings=[],
    )


if __name__ == "__main__":
    listener = socket.create_server(("127.0.0.1", 0))
    print("listening on 127.0.0.1:%d" % listener.getsockname()[1], flush=True)
    uvicorn.Server(uvicorn.Config(app, log_level="warning", access_log=False)).run(sockets=[listener])
