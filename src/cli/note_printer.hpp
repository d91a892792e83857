// Prints the notes of a conversion above a progress bar, and ignores its other events.
#pragma once

#include "cli/messages.hpp"
#include "cli/progress_bar.hpp"
#include "convert/events.hpp"

namespace isoextract::cli {

// `messages` and `bar` must outlive this object.
class NotePrinter final : public convert::Events {
 public:
  NotePrinter(const Messages& messages, ProgressBar& bar) : messages_(messages), bar_(bar) {}
  void note(const Note& note) override {
    bar_.above([&] { messages_.note(note); });
  }

 private:
  const Messages& messages_;
  ProgressBar& bar_;
};

}  // namespace isoextract::cli
