// Keeps gzip streams that stopped in the middle of a file, so that reading the frames of a compressed file one after
// another inflates it once, and not from its start for each frame.
#pragma once

#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "base/context.hpp"
#include "files/file_bytes.hpp"
#include "files/file_version.hpp"
#include "files/gzip_stream.hpp"

namespace isoextract::files {

// A stream and the bytes that it has inflated and the reader has not read yet.
struct ParkedStream {
  std::uint64_t position = 0;  // of the first unread byte in the content
  std::vector<std::byte> unread;
  GzipStream stream;
};

// Holds the streams parked last. Each takes about 300 KB and its unread bytes. Safe to use from several threads.
class ParkedStreams {
 public:
  explicit ParkedStreams(std::size_t most) : most_(most) {}

  void park(const FileVersion& version, ParkedStream stream);
  // Returns a copy of the file's parked stream that is nearest to `position` and not after it; nothing if none is.
  [[nodiscard]] std::optional<ParkedStream> find(const InputFile& file, const FileVersion& version,
                                                 std::uint64_t position) const;

 private:
  struct Entry {
    FileVersion version;
    ParkedStream parked;
  };

  std::size_t most_;
  mutable std::mutex mutex_;
  std::list<Entry> entries_;  // the one parked last is last
};

// Keeps at most `most` streams as long as this object lives: for readers in the context, and in contexts that are made
// from it later.
class StreamKeeper {
 public:
  StreamKeeper(const Context& context, std::size_t most);
  StreamKeeper(const StreamKeeper&) = delete;
  StreamKeeper& operator=(const StreamKeeper&) = delete;
  ~StreamKeeper();

 private:
  std::shared_ptr<OpenedFiles> opened_;
};

// Returns the streams that a StreamKeeper keeps for this context, or null.
[[nodiscard]] std::shared_ptr<ParkedStreams> kept_streams(const Context& context);

}  // namespace isoextract::files
