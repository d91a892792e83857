// Runs the steps of writing a file and remembers the first failure.
#pragma once

#include <exception>
#include <filesystem>
#include <new>
#include <optional>
#include <type_traits>
#include <utility>

#include <fmt/format.h>

#include "base/allocation_error.hpp"
#include "base/context.hpp"
#include "base/error.hpp"

namespace isoextract::mesh_io {

// Runs step(), which returns a Result, and stores its error in `failure`; turns exceptions into errors. Does not run
// step() after an earlier failure or a cancellation, so that an incomplete file is never committed.
template <class Step>
[[nodiscard]] std::invoke_result_t<Step> attempt(std::optional<Error>& failure, const Context& context,
                                                 const std::filesystem::path& path, Step step) {
  if (failure) return tl::unexpected<Error>(*failure);
  try {
    auto going_on = context.check();
    auto done = going_on ? step() : std::invoke_result_t<Step>(tl::unexpected<Error>(std::move(going_on.error())));
    if (!done) failure = done.error();
    return done;
  } catch (const std::bad_alloc&) {
    failure = allocation_error(fmt::format("{}: not enough memory to write it", path.string()),
                               {Remedy::use, Setting::parts});
  } catch (const std::exception& error) {  // thrown by a library
    failure = Error{ErrorCode::output, fmt::format("{}: cannot write: {}", path.string(), error.what()), {}};
  }
  return tl::unexpected<Error>(*failure);
}

}  // namespace isoextract::mesh_io
