"""A container file for simulation and CI, and for real links given to it."""

from __future__ import annotations

from firmware_protocol.version import __version__


def container_file(config: str) -> str:
    """For podman and docker: installed from the folder in which it is built, kernels compiled at build time."""
    return f"""# Written by `gimbal-hil service container` {__version__}. In a checkout:
#   podman build -t gimbal-hil .
#   podman run --rm -v ./runs:/runs gimbal-hil
# On a real link, at a fixed rate (the host's limits count):
#   podman run --rm -v ./runs:/runs --device /dev/ttyACM0 --network host --cap-add SYS_NICE --ulimit rtprio=95 \\
#     --ulimit memlock=-1 gimbal-hil
FROM python:3.11-slim
WORKDIR /src
COPY . .
RUN pip install --no-cache-dir ".[metrics]"
RUN useradd --create-home gimbal && mkdir /runs && chown gimbal /runs
USER gimbal
ENV GIMBAL_HIL_CACHE=/home/gimbal/cache
# for the processor that builds; on another one the first start compiles again
RUN gimbal-hil warm
WORKDIR /runs
VOLUME /runs
STOPSIGNAL SIGTERM
ENTRYPOINT ["gimbal-hil"]
CMD ["daemon", "--config", "{config}"]
"""
