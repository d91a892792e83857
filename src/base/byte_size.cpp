#include "base/byte_size.hpp"

#include <array>
#include <charconv>
#include <cmath>

#include <fmt/format.h>

namespace isoextract {

Result<std::uint64_t> parse_byte_size(std::string_view text) {
  const auto bad = [&] {
    return fail(ErrorCode::usage, fmt::format("expected a size such as 512M or 2G, found '{}'", text));
  };
  double number = 0;
  const auto [rest, status] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (status != std::errc{} || !(number >= 0)) return bad();
  std::string_view suffix(rest, static_cast<std::size_t>(text.data() + text.size() - rest));
  int power = 0;
  if (!suffix.empty() && suffix != "B") {
    constexpr std::string_view kUnits = "KMGT";
    const std::size_t unit = kUnits.find(suffix.front() & ~0x20);
    suffix.remove_prefix(1);
    if (unit == std::string_view::npos || !(suffix.empty() || suffix == "B" || suffix == "iB")) return bad();
    power = static_cast<int>(unit) + 1;
  }
  const double bytes = std::ldexp(number, 10 * power);
  if (!(bytes < 0x1p63)) return bad();
  return static_cast<std::uint64_t>(bytes);
}

std::string format_byte_size(std::uint64_t bytes) {
  constexpr std::array kUnits{"B", "KiB", "MiB", "GiB", "TiB", "PiB", "EiB"};
  auto value = static_cast<double>(bytes);
  std::size_t unit = 0;
  // Three significant digits show the whole integer part only if it is below 1000.
  while (value >= (unit == 0 ? 1024 : 999.5) && unit + 1 < kUnits.size()) {
    value /= 1024;
    ++unit;
  }
  return unit == 0 ? fmt::format("{} B", bytes) : fmt::format("{:.3g} {}", value, kUnits[unit]);
}

}  // namespace isoextract
