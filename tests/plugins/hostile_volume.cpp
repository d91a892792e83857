// A plug-in for the tests that does what a library may do in the hands of a damaged file. A file is
// "hostile STAGE DEED": at the stage (list or open) the deed is done, and then a box of 2 x 2 x 2 samples is given.
#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iostream>
#include <map>
#include <string>
#include <vector>

#include <volume_plugin.h>
#include "plugin_host/detail/plugin_messages.hpp"

namespace {

using isoextract::plugin_host::MessageKind;

constexpr int kProgram = 3;  // the socket to it
const std::array<float, 8> kValues{0, 0, 0, 0, 1, 1, 1, 1};
const std::string kLongName(1 << 20, 'n');

std::string opened_path;
std::string note;
isoextract_volume_grid grid{};
isoextract_sparse_samples sparse{};
std::vector<isoextract_sparse_block> blocks;

void send_words(const std::vector<std::uint64_t>& words) {
  [[maybe_unused]] const auto sent = ::write(kProgram, words.data(), words.size() * sizeof(std::uint64_t));
}

// An answer of that many words behind its length.
void say_words(const std::vector<std::uint64_t>& words) {
  send_words({words.size() * sizeof(std::uint64_t)});
  send_words(words);
}

void take_memory_without_end() {
  for (;;) {
    auto* block = new char[1 << 20];
    std::memset(block, 1, 1 << 20);
    note.push_back(block[7]);
  }
}

// Tries forbidden actions and lists those that were possible.
void try_the_world(const std::string& path) {
  const auto tried = [&](const char* what, bool done) {
    if (done) note += std::string(note.empty() ? "" : ", ") + what;
  };
  tried("wrote a file", ::open((path + ".new").c_str(), O_CREAT | O_WRONLY, 0600) >= 0);
  tried("opened the file for writing", ::open(path.c_str(), O_RDWR) >= 0);
  tried("removed the file", ::unlink(path.c_str()) == 0);
  tried("renamed the file", std::rename(path.c_str(), (path + ".old").c_str()) == 0);
  tried("opened a socket", ::socket(AF_INET, SOCK_STREAM, 0) >= 0);
  const pid_t child = ::fork();
  if (child == 0) ::_exit(0);
  tried("forked", child > 0);
  tried("signalled its parent", ::kill(::getppid(), 0) == 0);
  tried("queued a signal for its parent", ::sigqueue(::getppid(), 0, {}) == 0);
  tried("gave its parent a descriptor's signals", ::fcntl(kProgram, F_SETOWN, ::getppid()) == 0);
  if (note.empty()) note = "could do nothing";
}

// As a worker in the hands of its file would speak: counts and places that are not there.
void lie_about_blocks() {
  constexpr std::uint64_t kMany = std::uint64_t{1} << 60;
  say_words({static_cast<std::uint64_t>(MessageKind::grid_opened),
             0,
             0,
             0,
             1,
             ISOEXTRACT_F32,
             0,
             8,
             0,
             0,
             0,
             0,
             0,
             0,
             kMany,
             0,
             0,
             0,
             0,
             0});
  ::_exit(0);
}
void lie_about_places() {
  say_words({static_cast<std::uint64_t>(MessageKind::grid_opened),
             0,
             0,
             0,
             1,
             ISOEXTRACT_F32,
             0,
             8,
             0,
             0,
             0,
             0,
             0,
             0,
             1,
             40,
             1 << 20,
             0,
             0,
             0});
  ::_exit(0);
}

void do_deed(const std::string& deed, const char* path) {
  static const std::map<std::string, void (*)(const std::string&)> kDeeds{
      {"crash", [](const std::string&) { std::raise(SIGSEGV); }},
      {"abort", [](const std::string&) { std::abort(); }},
      {"exit", [](const std::string&) { ::_exit(0); }},
      {"wait",
       [](const std::string&) {
         ::prctl(PR_SET_NAME, "waiting", 0, 0, 0);  // tells the tests that it is this far
         for (;;) ::pause();
       }},
      {"spin",
       [](const std::string&) {
         for (;;) asm volatile("");
       }},
      {"allocate", [](const std::string&) { take_memory_without_end(); }},
      {"print",
       [](const std::string&) {
         std::cerr << "WARN: something\x1b[31m is odd\n" << std::flush;
         std::cout << "and so on\n" << std::flush;
       }},
      {"print-much",
       [](const std::string&) {
         for (int i = 0; i < 100000; ++i) std::cerr << "all work and no play\n";
       }},
      {"world", try_the_world},
      {"lie-blocks", [](const std::string&) { lie_about_blocks(); }},
      {"lie-places", [](const std::string&) { lie_about_places(); }},
      {"lie-length",
       [](const std::string&) {
         send_words({~std::uint64_t{0}, 1, 2});
         for (;;) ::pause();
       }},
      {"lie-list",
       [](const std::string&) {
         say_words({static_cast<std::uint64_t>(MessageKind::listed), 1U << 30U});
         ::_exit(0);
       }},
      {"chatter",
       [](const std::string&) {
         for (;;) say_words({static_cast<std::uint64_t>(MessageKind::reserve), 0});
       }},
      {"greed",
       [](const std::string&) {
         say_words({static_cast<std::uint64_t>(MessageKind::allocate), ~std::uint64_t{0}});
         ::_exit(0);
       }},
  };
  if (const auto found = kDeeds.find(deed); found != kDeeds.end()) found->second(path);
}

struct Wanted {
  std::string stage;
  std::string deed;
};
Wanted read_wanted(const std::string& path) {
  std::ifstream file(path);
  std::string word;
  Wanted wanted;
  file >> word >> wanted.stage >> wanted.deed;
  return wanted;
}

int probe(const unsigned char* start, size_t bytes, const char* /*given*/) {
  return bytes >= 7 && std::memcmp(start, "hostile", 7) == 0 ? 1 : 0;
}

int list(const isoextract_volume_request* request, const isoextract_plugin_host* /*host*/,
         isoextract_volume_list* list) {
  opened_path = request->path;
  const Wanted wanted = read_wanted(opened_path);
  if (wanted.stage == "list") do_deed(wanted.deed, opened_path.c_str());
  grid = {};
  grid.name = wanted.deed == "name" ? kLongName.c_str() : "";
  grid.type_name = "float";
  grid.world_space = "";
  grid.sample_type = ISOEXTRACT_F32;
  grid.is_sparse =
      wanted.deed.starts_with("sparse") || wanted.deed.starts_with("lie") || wanted.deed == "greed" ? 1 : 0;
  for (auto& dim : grid.dims) dim = wanted.deed == "huge" ? 2000 : 2;
  for (int i = 0; i < 3; ++i) grid.index_to_world[5 * i] = 1;
  grid.has_placement = 1;
  grid.slope = 1;
  grid.components = 1;
  grid.volumes = 1;
  *list = {};
  list->grids = &grid;
  list->count = 1;
  return 0;
}

void free_list(isoextract_volume_list* /*list*/) {}

int open(const isoextract_volume_list* /*list*/, const isoextract_volume_selection* selection,
         const isoextract_plugin_host* /*host*/, isoextract_volume_samples* samples) {
  const Wanted wanted = read_wanted(opened_path);
  note.clear();
  if (wanted.stage == "open") do_deed(wanted.deed, opened_path.c_str());
  if (grid.is_sparse == 0) std::memcpy(selection->box, kValues.data(), sizeof(kValues));
  *samples = {sizeof(kValues), nullptr, 0, 0, note.c_str(), nullptr};
  if (grid.is_sparse != 0) {
    // Blocks of the plug-in's own memory; of "sparse-unsorted" in the wrong order.
    static std::vector<float> values(2 * 512, 0.0F);
    values[100] = 1;
    blocks = {{{0, 0, 0}, values.data()}, {{8, 0, 0}, values.data() + 512}};
    if (wanted.deed == "sparse-unsorted") std::swap(blocks[0], blocks[1]);
    sparse = {ISOEXTRACT_F32, blocks.data(), blocks.size(), nullptr, 0, 0, {0, 0, 0}, {15, 7, 7}, 1024};
    samples->sparse = &sparse;
  }
  return 0;
}

void free_samples(isoextract_volume_samples* /*samples*/) {}

const char* error_text() { return ""; }

constexpr isoextract_volume_plugin_v4 kPlugin{
    ISOEXTRACT_VOLUME_PLUGIN_VERSION, "hostile", "hostile", probe, list, free_list, open, free_samples, error_text};

}  // namespace

// HOSTILE_LOADING is the number of a signal that ends or stops the process that loads this.
const isoextract_volume_plugin_v4* isoextract_volume_plugin() {
  if (const char* number = std::getenv("HOSTILE_LOADING")) std::raise(std::atoi(number));
  return &kPlugin;
}
