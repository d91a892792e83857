#include "files/parked_streams.hpp"

#include <utility>

#include "files/detail/opened_files.hpp"

namespace isoextract::files {

void ParkedStreams::park(const FileVersion& version, ParkedStream stream) {
  const std::lock_guard lock(mutex_);
  if (entries_.size() == most_) entries_.pop_front();
  entries_.push_back({version, std::move(stream)});
}

std::optional<ParkedStream> ParkedStreams::find(const InputFile& file, const FileVersion& version,
                                                std::uint64_t position) const {
  const std::lock_guard lock(mutex_);
  const Entry* nearest = nullptr;
  for (const Entry& entry : entries_) {
    if (entry.version != version || entry.parked.position > position) continue;
    if (nearest == nullptr || entry.parked.position >= nearest->parked.position) nearest = &entry;
  }
  if (nearest == nullptr) return std::nullopt;
  const ParkedStream& parked = nearest->parked;
  return ParkedStream{parked.position, parked.unread, parked.stream.copy_for(file)};
}

StreamKeeper::StreamKeeper(const Context& context, std::size_t most) : opened_(opened_files_of(context)) {
  if (most > 0) opened_->keep_streams(std::make_shared<ParkedStreams>(most));
}

StreamKeeper::~StreamKeeper() { opened_->keep_streams(nullptr); }

std::shared_ptr<ParkedStreams> kept_streams(const Context& context) { return opened_files_of(context)->streams(); }

}  // namespace isoextract::files
