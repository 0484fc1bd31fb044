# tendon in a container, without root:
#
#     docker build -t tendon .
#     docker run --rm --user "$(id -u):$(id -g)" -v "$PWD:/work" tendon sweep study.toml
#
# The first stage compiles the kernel; the second has neither a compiler nor this source tree.

FROM python:3.12-slim AS build
RUN apt-get update && apt-get install --yes --no-install-recommends gcc libc6-dev && rm -rf /var/lib/apt/lists/*
WORKDIR /source
COPY pyproject.toml constraints.txt setup.py MANIFEST.in README.md LICENSE CHANGELOG.md CITATION.cff ./
COPY tendon_cli tendon_cli
COPY configs configs
RUN python -m venv /opt/tendon && /opt/tendon/bin/pip install --no-cache-dir --constraint constraints.txt '.[dask,xarray]' \
    && /opt/tendon/bin/python -P -c 'from tendon_cli import kernel; assert kernel.kind(), "the kernel was not compiled"'

FROM python:3.12-slim
COPY --from=build /opt/tendon /opt/tendon
# Without a home of its own matplotlib would warn, and whoever --user names may write nowhere but to the mounted folder.
ENV PATH=/opt/tendon/bin:$PATH PYTHONDONTWRITEBYTECODE=1 MPLCONFIGDIR=/tmp/matplotlib HOME=/tmp
RUN useradd --create-home --uid 1000 tendon && mkdir /work && chown tendon /work
USER tendon
WORKDIR /work
ENTRYPOINT ["tendon"]
CMD ["--help"]
