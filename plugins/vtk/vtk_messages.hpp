// Captures VTK's messages, which otherwise go to stderr. Shared by the plug-ins around VTK.
#pragma once

#include <cstddef>
#include <mutex>
#include <string>

#include <vtkLogger.h>
#include <vtkOutputWindow.h>
#include <vtkSmartPointer.h>

namespace isoextract_vtk {

// VTK's messages in this thread since a reader cleared them, without the messages that follow the first 2,000 bytes.
inline std::string& vtk_messages() {
  thread_local std::string messages;
  return messages;
}

class MessageWindow : public vtkOutputWindow {
 public:
  static MessageWindow* New() {  // NOLINT(readability-identifier-naming): as VTK has it
    auto* window = new MessageWindow;
    window->InitializeObjectBase();
    return window;
  }
  void DisplayText(const char* text) override {  // NOLINT(readability-identifier-naming)
    constexpr std::size_t kMost = 2000;
    if (text != nullptr && vtk_messages().size() < kMost) vtk_messages() += text;
  }
};

inline void silence_vtk() {
  static std::once_flag once;
  std::call_once(once, [] {
    vtkOutputWindow::SetInstance(vtkSmartPointer<MessageWindow>::New());
    vtkLogger::SetStderrVerbosity(vtkLogger::VERBOSITY_OFF);
  });
}

// Returns the sentence of VTK's first message "ERROR: In file.cxx, line 12\nvtkClass (0x55..): sentence\n\n", or
// "Generic Warning: In file.cxx, line 12\nsentence\n\n"; "the file is damaged" if it is empty.
inline std::string first_sentence(const std::string& complaint) {
  const std::size_t place = complaint.find(": In ");
  std::size_t at = place == std::string::npos ? place : complaint.find('\n', place);
  at = at == std::string::npos ? 0 : at + 1;
  const std::size_t end = complaint.find('\n', at);
  if (const std::size_t object = complaint.find("): ", at); object < end) at = object + 3;
  const std::string text = complaint.substr(at, complaint.find('\n', at) - at);
  return text.empty() ? "the file is damaged" : text;
}

}  // namespace isoextract_vtk
