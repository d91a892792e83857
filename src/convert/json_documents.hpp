// Names and versions of the JSON documents that the program writes. The report is not among them: its version is
// kReportSchemaVersion (outcome.hpp). docs/schemas/NAME.schema.json describes the document isoextract/NAME/VERSION and
// must change with it. Raise the version if a program written for the old document would misread the new one.
#pragma once

#include <array>

#include "base/enum_words.hpp"

namespace isoextract::convert {

enum class JsonDocument {
  bench,
  check,
  compare,
  devices,
  formats,
  gpu_threads,
  info,
  manifest,
  progress,
  render,
  stability,
  stability_cases,
  table,
  verify,
};
// Returns the values of the member "schema". In a document that is an array, each element has this member; in a
// document of lines, only the first line has it.
constexpr auto words_of(JsonDocument /*type*/) {
  return std::array{Word{JsonDocument::bench, "isoextract/bench/1"},
                    Word{JsonDocument::check, "isoextract/check/1"},
                    Word{JsonDocument::compare, "isoextract/compare/1"},
                    Word{JsonDocument::devices, "isoextract/devices/1"},
                    Word{JsonDocument::formats, "isoextract/formats/1"},
                    Word{JsonDocument::gpu_threads, "isoextract/gpu-threads/1"},
                    Word{JsonDocument::info, "isoextract/info/1"},
                    Word{JsonDocument::manifest, "isoextract/manifest/1"},
                    Word{JsonDocument::progress, "isoextract/progress/1"},
                    Word{JsonDocument::render, "isoextract/render/1"},
                    Word{JsonDocument::stability, "isoextract/stability/1"},
                    Word{JsonDocument::stability_cases, "isoextract/stability-cases/1"},
                    Word{JsonDocument::table, "isoextract/table/1"},
                    Word{JsonDocument::verify, "isoextract/verify/1"}};
}

}  // namespace isoextract::convert
