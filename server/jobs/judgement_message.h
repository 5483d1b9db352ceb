#pragma once
#include <string>
#include <string_view>
#include <variant>

#include "server/store/capture_store.h"

namespace anyrate {

/// A file that cameras.json names and that is not there.
struct MissingFile {
    std::string path;
    friend bool operator==(const MissingFile&, const MissingFile&) = default;
};
/// Something that is wrong with a capture. @see CaptureVerdict
struct CaptureFault {
    std::string path, sentence;
    friend bool operator==(const CaptureFault&, const CaptureFault&) = default;
};
/// The capture could not be looked through; nothing else will come.
struct NotReadable {
    std::string sentence;
    friend bool operator==(const NotReadable&, const NotReadable&) = default;
};
/// All has been said.
struct JudgementEnd {
    friend bool operator==(const JudgementEnd&, const JudgementEnd&) = default;
};

/// What a process that looks through an upload tells the server, one JSON object a line on its standard output.
using JudgementMessage = std::variant<CaptureFile, MissingFile, CaptureFault, NotReadable, JudgementEnd>;

/// One line with its line feed. What is not UTF-8 is replaced.
std::string encode_judgement_message(const JudgementMessage& message);
/// @throws DecodeError the line is no such message
JudgementMessage decode_judgement_message(std::string_view line);

}  // namespace anyrate
