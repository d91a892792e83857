"""How the extraction grows with threads and with the size of the volume."""

from measuring import extraction, record
from measuring.tables import median, number, power, ratio, table

NAME = "threads"
TITLE = "Extraction time by threads and volume size"
FIELD = "gyroid"


def self_arguments(kind, size, threads):
    return ["--self", "--fields", FIELD, "--sizes", size, "--types", kind, "--threads", ",".join(map(str, threads))]


def measure(setting):
    measured = record.Record(NAME, setting.isoextract, setting.quick)
    cores = record.cores()
    counts = sorted({1, cores})
    size, sizes = (64, (32, 64)) if setting.quick else (512, (256, 512, 1024))
    rounds = 3 if setting.quick else 15
    commands, by_threads, by_size = [], [], []
    for kind in ("f32", "u8"):
        # In turn for the ratios; for cold times each number of threads needs a process that did nothing before.
        together = self_arguments(kind, size, counts)
        rows = [row for row in extraction.measure(setting, together, 1, rounds) if extraction.ours(row)]
        commands.append(extraction.shown([*together, "--runs", rounds]))
        for row in rows:
            alone = self_arguments(kind, size, [row["threads"]])
            first = extraction.measure(setting, alone, 1 if setting.quick else 3, 1)
            row["cold_ms"] = next(other["cold_ms"] for other in first if extraction.ours(other))
        by_threads.append(rows)
    commands.append(extraction.shown([*self_arguments("f32", size, [1]), "--runs", 1]) + "  # cold, and so on")
    for other in sizes:
        arguments = self_arguments("u8", other, [cores])
        by_size += [row for row in extraction.measure(setting, arguments, 1, 7) if extraction.ours(row)]
        commands.append(extraction.shown([*arguments, "--runs", 7]))
    figures = {"rounds": rounds, "threads": by_threads, "sizes": by_size}
    return measured.finish(counts, {}, commands, figures)


def thread_rows(figures):
    for rows in figures["threads"]:
        for row in rows:
            yield [f"{FIELD} {power(row['dims'][0])}, {row['type']}", row["threads"], number(median(row["cold_ms"])),
                   number(median(row["warm_ms"])), ratio(median(rows[0]["cold_ms"]) / median(row["cold_ms"])),
                   ratio(extraction.ratio(rows[0], row, "warm_ms"))]


def size_rows(figures):
    before = None
    for row in figures["sizes"]:
        bytes_of = row["bytes_read"] + row["bytes_written"]
        cold, warm = median(row["cold_ms"]), median(row["warm_ms"])
        growth = [ratio(now / then) for now, then in zip((bytes_of, cold, warm), before)] if before else ["", "", ""]
        yield [f"{FIELD} {power(row['dims'][0])}, {row['type']}", number(bytes_of / 2**20), number(cold), number(warm), *growth]
        before = (bytes_of, cold, warm)


def processes(row):
    count = len(row["cold_ms"])
    return "one process" if count == 1 else f"median of {({3: 'three'}).get(count, count)} processes"


def page(measured):
    figures = measured["figures"]
    threads = table(["input", "threads:", "cold, ms:", "warm, ms:", "speed-up over 1 thread, cold:", "speed-up, warm:"],
                    thread_rows(figures))
    sizes = table(["input", "bytes, MiB:", "cold, ms:", "warm, ms:", "bytes / row above:", "cold / row above:", "warm / row above:"],
                  size_rows(figures))
    cold_of_threads = processes(figures["threads"][0][0])
    cold_of_sizes = processes(figures["sizes"][0])
    cores = max(measured["threads"])
    return f"""How the run time of isoextract's marching cubes depends on the number of threads and on the size of the volume.
`build/bench/extraction_benchmark --self` measures the extraction alone, from samples in memory to a mesh in memory.

- **Cold** is the first extraction of a process that has only made the samples before.
- **Warm** is the median of the extractions after the first one in a process.

## Threads

- Cold times are the {cold_of_threads}, each with one number of threads.
- Warm times are of one process, which ran each number of threads in each of {figures['rounds']} rounds. The warm speed-up is the median of
  the rounds' speed-ups.

{threads}

## Size

The program ran on {cores} threads; cold times are of {cold_of_sizes} for each size. *Bytes* is the size of the samples
plus that of the mesh. The last three columns divide a figure by that of the row above.

{sizes}
"""
