# The program with everything that reports, pages, fits and tables need:
#   docker build -t stickslip .
#   docker run --rm -v "$PWD:/data" stickslip figure 7
FROM python:3.11-slim
COPY . /src
RUN pip install --no-cache-dir --constraint /src/constraints.txt "/src[report,explore,table,fit,dask]" && rm -r /src
WORKDIR /data
# Compiled code is kept here: a volume spares half a minute at each start.
ENV XDG_CACHE_HOME=/cache
VOLUME /cache
ENTRYPOINT ["stickslip"]
CMD ["--help"]
