// What happens when a mapped input is cut off, or its disk fails, while the program looks at it.
#pragma once

namespace isoextract::cli {

// From now on that ends the program with a message and the exit code of an input error, instead of SIGBUS. Meshes
// written before stay; of later ones there is nothing yet: an output is opened when its samples are done with.
void report_lost_input();

}  // namespace isoextract::cli
