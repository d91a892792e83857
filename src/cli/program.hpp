// Runs the program and returns its exit code.
#pragma once

namespace isoextract::cli {

// Runs the program and returns its exit code. Handles signals for the whole process; prints all errors.
[[nodiscard]] int run(int argc, char** argv);

}  // namespace isoextract::cli
