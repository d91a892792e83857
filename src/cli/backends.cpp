#include "cli/backends.hpp"

namespace isoextract {

std::string_view backend_name(Backend backend) { return backend == Backend::cpu ? "cpu" : "gpu"; }

Result<std::unique_ptr<Extractor>> open_backend(Backend backend) {
  if (backend == Backend::cpu) return make_cpu_extractor();
  return fail(ErrorKind::unavailable, "this build has no GPU backend yet");
}

}  // namespace isoextract
