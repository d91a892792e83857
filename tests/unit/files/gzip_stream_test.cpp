#include "files/gzip_stream.hpp"

#include <algorithm>
#include <string>

#include <gtest/gtest.h>
#include <zlib.h>

#include "support/temp_folder.hpp"

namespace isoextract::files {
namespace {

using test::TempFolder;

// Stored without compression, so that the size is known; the header contains a name of any length.
std::string member(const std::string& content, const std::string& name = {}) {
  z_stream stream{};
  EXPECT_EQ(::deflateInit2(&stream, 0, Z_DEFLATED, 16 + MAX_WBITS, 8, Z_DEFAULT_STRATEGY), Z_OK);
  std::string named = name;
  gz_header header{};
  header.name = reinterpret_cast<Bytef*>(named.data());
  if (!name.empty()) {
    EXPECT_EQ(::deflateSetHeader(&stream, &header), Z_OK);
  }
  std::string input = content;
  std::string packed(content.size() + content.size() / 1000 + name.size() + 100, '\0');
  stream.next_in = reinterpret_cast<Bytef*>(input.data());
  stream.avail_in = static_cast<uInt>(input.size());
  stream.next_out = reinterpret_cast<Bytef*>(packed.data());
  stream.avail_out = static_cast<uInt>(packed.size());
  EXPECT_EQ(::deflate(&stream, Z_FINISH), Z_STREAM_END);
  packed.resize(packed.size() - stream.avail_out);
  ::deflateEnd(&stream);
  return packed;
}

std::string text(std::size_t size) {
  std::string bytes(size, '\0');
  for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<char>('a' + i * i % 23);
  return bytes;
}

Result<std::string> inflated(const std::string& packed, std::size_t offset = 0, std::size_t at_once = 1 << 16) {
  const TempFolder folder;
  test::write_bytes(folder / "a.gz", packed);
  const auto file = TRY(InputFile::open(folder / "a.gz", Context()));
  auto stream = TRY(GzipStream::open(file, offset));
  std::string all;
  std::string some(at_once, '\0');
  for (;;) {
    const std::size_t got = TRY(stream.inflate(std::as_writable_bytes(std::span(some))));
    all.append(some, 0, got);
    if (got < some.size()) return all;
  }
}

TEST(GzipStream, ReadsMembersAcrossBlockBoundaries) {
  // Blocks of 256 KiB are read: the second member starts before, at and after the end of a block.
  constexpr std::size_t kBlock = std::size_t{1} << 18;
  const std::size_t overhead = member(text(kBlock)).size() - kBlock;
  for (const int shift : {-3, -2, -1, 0, 1}) {
    const std::string first = text(kBlock - overhead - static_cast<std::size_t>(8 - shift));
    const std::string packed = member(first) + member("the second") + member("") + member("the last");
    EXPECT_EQ(inflated(packed).value(), first + "the secondthe last") << shift;
  }
}

TEST(GzipStream, StartsAtOffsetAndIgnoresTrailingBytes) {
  const std::string content = text(100'000);
  EXPECT_EQ(inflated("a header\n" + member(content), 9).value(), content);
  EXPECT_EQ(inflated(member(content) + std::string(600, '\0')).value(), content);
  EXPECT_EQ(inflated(member(content) + "\x1f", 0, 1000).value(), content);
  EXPECT_EQ(inflated(member(content, "a name.raw")).value(), content);
}

TEST(GzipStream, RejectsDamagedAndOtherData) {
  const std::string content = text(100'000);
  const std::string packed = member(content);
  const auto why = [](const std::string& bytes) {
    const auto read = inflated(bytes);
    return read ? std::string("nothing") : read.error().message.substr(read.error().message.find("a.gz"));
  };
  for (const std::size_t left : {std::size_t{3}, std::size_t{20}, packed.size() / 2, packed.size() - 1}) {
    EXPECT_EQ(why(packed.substr(0, left)), "a.gz: the gzip data is damaged or cut off: unexpected end of file");
  }
  std::string changed = packed;
  changed[packed.size() - 6] ^= 1;  // of the checksum
  EXPECT_EQ(why(changed), "a.gz: the gzip data is damaged or cut off: incorrect data check");
  changed = packed;
  changed[packed.size() / 2] ^= 1;
  EXPECT_EQ(why(changed), "a.gz: the gzip data is damaged or cut off: incorrect data check");
  EXPECT_EQ(why(packed + packed.substr(0, 100)), "a.gz: the gzip data is damaged or cut off: unexpected end of file");
  EXPECT_EQ(why("not gzip"), "a.gz: expected gzip data, found other bytes");
}

}  // namespace
}  // namespace isoextract::files
