// Private to fuzz_seeds.
#pragma once

#include <filesystem>
#include <string>

namespace isoextract::test {

// Writes the seeds of fuzz_zarr.
void write_zarr_seeds(const std::filesystem::path& folder);

}  // namespace isoextract::test
