#include "cli/commands.hpp"

int main(int argc, char** argv) { return isoextract::cli::run(argc, argv); }
