// Runs the program and returns its exit code.
#pragma once

namespace isoextract::cli {

[[nodiscard]] int run(int argc, char** argv);

}  // namespace isoextract::cli
