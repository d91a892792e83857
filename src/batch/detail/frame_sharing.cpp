#include "batch/detail/frame_sharing.hpp"

#include <chrono>
#include <cstdint>
#include <utility>

#include "base/packed_values.hpp"
#include "convert/json_values.hpp"

namespace isoextract::batch {
namespace {

constexpr std::uint64_t kNoFrame = ~std::uint64_t{0};
constexpr std::chrono::milliseconds kPatience{200};

// The first byte of a message to rank 0.
enum class Request : char { next, finished, ends };

void put(Packer& packer, const Notes& notes) {
  packer.put(static_cast<std::uint64_t>(notes.size()));
  for (const Note& note : notes) packer.put(note.id).put(note.text);
}

void put(Packer& packer, const std::vector<std::string>& texts) {
  packer.put(static_cast<std::uint64_t>(texts.size()));
  for (const std::string& text : texts) packer.put(text);
}

Notes notes_of(Unpacker& from) {
  Notes notes;
  const auto count = from.get<std::uint64_t>();
  for (std::uint64_t i = 0; i < count; ++i) {
    const auto id = from.get<NoteId>();
    notes.push_back({id, from.get<std::string>()});
  }
  return notes;
}

std::vector<std::string> texts_of(Unpacker& from) {
  std::vector<std::string> texts(from.get<std::uint64_t>());
  for (std::string& text : texts) text = from.get<std::string>();
  return texts;
}

}  // namespace

std::string packed(const FinishedFrame& finished) {
  const FrameRow& row = finished.row;
  // A record of the figures alone, if the manifest gets none.
  FrameRecord figures;
  figures.frame = row.frame;
  figures.figures = row.figures;
  Packer packer;
  packer.put(static_cast<std::uint64_t>(finished.frame)).put(row.status).put(row.error).put(finished.is_converted);
  put(packer, row.outputs);
  packer.put(finished.record.has_value());
  packer.put(convert::json_line(json_of(finished.record ? *finished.record : figures)));
  packer.put(finished.error.has_value());
  if (finished.error) packer.put(*finished.error);
  put(packer, finished.set_aside);
  put(packer, finished.notes);
  put(packer, finished.field_notes);
  packer.put(finished.empty_picture);
  return packer.take();
}

std::optional<FinishedFrame> unpacked_frame(std::string_view bytes) {
  Unpacker from(bytes);
  FinishedFrame finished;
  finished.frame = from.get<std::uint64_t>();
  finished.row.status = from.get<FrameStatus>();
  finished.row.error = from.get<std::string>();
  finished.is_converted = from.get<bool>();
  finished.row.outputs = texts_of(from);
  const bool has_record = from.get<bool>();
  auto record = record_of(convert::Json::parse(from.get<std::string>(), nullptr, false));
  if (!record) return std::nullopt;
  finished.row.figures = record->figures;
  if (has_record) finished.record = std::move(*record);
  if (from.get<bool>()) finished.error = from.get<Error>();
  finished.set_aside = texts_of(from);
  finished.notes = notes_of(from);
  finished.field_notes = notes_of(from);
  finished.empty_picture = from.get<bool>();
  return finished;
}

FrameDesk::FrameDesk(Ranks& ranks, std::size_t count, Begin begin, Accept accept)
    : ranks_(ranks), count_(count), begin_(std::move(begin)), accept_(std::move(accept)), thread_([this] {
        answer();
      }) {}

FrameDesk::~FrameDesk() { stop(); }

std::optional<std::size_t> FrameDesk::next() {
  if (stops_) return std::nullopt;
  const std::size_t place = next_++;
  return place < count_ ? std::optional(place) : std::nullopt;
}

Result<std::map<int, double>> FrameDesk::finish() {
  thread_.join();
  if (failure_) return tl::unexpected(std::move(*failure_));
  return std::move(done_);
}

void FrameDesk::answer() {
  while (static_cast<int>(done_.size()) + 1 < ranks_.size()) {
    const auto message = ranks_.receive(kPatience);
    Result<void> answered = message ? Result<void>() : tl::unexpected(message.error());
    if (message && *message) answered = answer(**message);
    if (answered) continue;
    failure_ = answered.error();
    stop();
    return;
  }
}

Result<void> FrameDesk::answer(const RankMessage& message) {
  Unpacker from(message.bytes);
  const auto request = from.get<Request>();
  if (request == Request::next) {
    const auto place = next();
    const bool begins = place && begin_(*place);
    if (place && !begins) stop();
    return ranks_.send(message.from, Packer().put(begins ? std::uint64_t{*place} : kNoFrame).take());
  }
  if (request == Request::ends) {
    done_[message.from] = from.get<double>();
    return {};
  }
  auto finished = unpacked_frame(from.get<std::string>());
  if (!finished) return fail(ErrorCode::unavailable, "a message of another rank is damaged");
  finished->row.rank = message.from;
  accept_(std::move(*finished));
  return {};
}

std::optional<std::size_t> FramesOfDesk::next() {
  auto asked = ranks_.send(0, Packer().put(Request::next).take());
  while (asked) {
    const auto message = ranks_.receive(kPatience);
    if (!message) asked = tl::unexpected(message.error());
    if (!message || !*message) continue;
    const auto place = Unpacker((*message)->bytes).get<std::uint64_t>();
    if (place == kNoFrame) return std::nullopt;
    return place;
  }
  keep(asked.error());
  return std::nullopt;
}

bool FramesOfDesk::tell(const FinishedFrame& finished) {
  const auto sent = ranks_.send(0, Packer().put(Request::finished).put(packed(finished)).take());
  if (!sent) keep(sent.error());
  return sent.has_value();
}

Result<void> FramesOfDesk::finish(double seconds) {
  if (failure_) return tl::unexpected(*failure_);
  return ranks_.send(0, Packer().put(Request::ends).put(seconds).take());
}

void FramesOfDesk::keep(const Error& error) {
  const std::lock_guard lock(mutex_);
  if (!failure_) failure_ = error;
}

}  // namespace isoextract::batch
