#include "cli/commands.hpp"

int main(int argc, char** argv) { return isoextract::run(argc, argv); }
