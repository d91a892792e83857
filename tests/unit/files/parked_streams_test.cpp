#include "files/parked_streams.hpp"

#include <string>

#include <gtest/gtest.h>
#include <zlib.h>

#include "support/temp_folder.hpp"

namespace isoextract::files {
namespace {

using test::TempFolder;

class ParkedStreamsTest : public testing::Test {
 protected:
  ParkedStreamsTest() {
    for (int i = 0; i < 100'000; ++i) content_ += std::to_string(i * 7919 % 100'003) + "\n";
    const gzFile out = ::gzopen((folder_ / "a.gz").c_str(), "wb");
    EXPECT_EQ(::gzwrite(out, content_.data(), static_cast<unsigned>(content_.size())),
              static_cast<int>(content_.size()));
    EXPECT_EQ(::gzclose(out), Z_OK);
  }

  [[nodiscard]] InputFile open() const { return *InputFile::open(folder_ / "a.gz", Context()); }

  // Parks a stream that has inflated `place` bytes, of which the last `unread` are not read.
  void park(ParkedStreams& streams, std::size_t place, std::size_t unread) const {
    const InputFile file = open();
    auto stream = GzipStream::open(file, 0);
    ASSERT_TRUE(stream);
    std::vector<std::byte> bytes(place);
    ASSERT_EQ(stream->inflate(bytes), place);
    streams.park(
        *version_of(file),
        {place - unread, {bytes.end() - static_cast<std::ptrdiff_t>(unread), bytes.end()}, std::move(*stream)});
  }

  // Returns the rest of the content from the parked stream on, with its position in front; "none" without one.
  [[nodiscard]] std::string rest_from(const ParkedStreams& streams, std::uint64_t position) const {
    const InputFile file = open();
    auto parked = streams.find(file, *version_of(file), position);
    if (!parked) return "none";
    std::string rest(reinterpret_cast<const char*>(parked->unread.data()), parked->unread.size());
    std::string more(content_.size(), '\0');
    const auto got = parked->stream.inflate(std::as_writable_bytes(std::span(more)));
    EXPECT_TRUE(got);
    rest.append(more, 0, *got);
    return std::to_string(parked->position) + " " + rest;
  }

  [[nodiscard]] std::string expected(std::size_t position) const {
    return std::to_string(position) + " " + content_.substr(position);
  }

  TempFolder folder_;
  std::string content_;
};

TEST_F(ParkedStreamsTest, ResumeAtTheNearestEarlierPosition) {
  ParkedStreams streams(3);
  EXPECT_EQ(rest_from(streams, 500'000), "none");
  park(streams, 300'000, 20);
  park(streams, 100'000, 0);
  park(streams, 200'000, 1000);
  EXPECT_EQ(rest_from(streams, 99'999), "none");
  EXPECT_EQ(rest_from(streams, 100'000), expected(100'000));
  EXPECT_EQ(rest_from(streams, 199'000), expected(199'000));
  EXPECT_EQ(rest_from(streams, 299'979), expected(199'000));
  EXPECT_EQ(rest_from(streams, 500'000), expected(299'980));
  EXPECT_EQ(rest_from(streams, 500'000), expected(299'980)) << "a stream is copied, so it can be used again";
  park(streams, 50'000, 0);
  EXPECT_EQ(rest_from(streams, 500'000), expected(199'000)) << "the one parked first made room";
  EXPECT_EQ(rest_from(streams, 60'000), expected(50'000));
}

TEST_F(ParkedStreamsTest, BelongToOneVersionOfAFile) {
  ParkedStreams streams(3);
  park(streams, 100'000, 0);
  const InputFile file = open();
  FileVersion other = *version_of(file);
  ++other.modified;
  EXPECT_FALSE(streams.find(file, other, 200'000));
}

TEST(StreamKeeper, KeepsStreamsForItsContextAndLaterParts) {
  const Context context;
  EXPECT_EQ(kept_streams(context), nullptr);
  {
    const StreamKeeper keeper(context, 2);
    EXPECT_NE(kept_streams(context), nullptr);
    EXPECT_EQ(kept_streams(context.part()), kept_streams(context));
    EXPECT_EQ(kept_streams(Context()), nullptr);
  }
  EXPECT_EQ(kept_streams(context), nullptr);
}

}  // namespace
}  // namespace isoextract::files
