// The program: arguments in, exit code out.
#pragma once

namespace isoextract::cli {

[[nodiscard]] int run(int argc, char** argv);

}  // namespace isoextract::cli
