# eai without a checkout: docker build -t eai .
# The data set has a licence of its own and is not in the image; it goes to a volume:
#   docker run --rm -v eai:/data eai data fetch
#   docker run --rm -v eai:/data -v "$PWD:/work" eai run --model eai/noisy --out runs
FROM python:3.13-slim

COPY pyproject.toml README.md LICENSE /src/
COPY src /src/src
RUN pip install --no-cache-dir '/src[run,planner,plots,analysis]' && rm -r /src

RUN useradd --create-home eai && mkdir /data /work && chown eai /data /work
USER eai
ENV EAI_DATA_DIR=/data
VOLUME /data
WORKDIR /work
ENTRYPOINT ["eai"]
