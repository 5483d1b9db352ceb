#include "core/capture/faults.h"

#include <algorithm>
#include <cstddef>
#include <string_view>

#include "core/error.h"

namespace anyrate {
namespace {

constexpr std::size_t max_part_bytes = 400;
constexpr std::size_t max_lines = 100;

/// Length of the well-formed UTF-8 character at the front of `text`; 0 if there is none. Overlong forms pass: they do
/// no harm in a message.
std::size_t utf8_length(std::string_view text) {
    const auto lead = static_cast<unsigned char>(text.front());
    const std::size_t n = lead < 0x80 ? 1 : lead < 0xC2 ? 0 : lead < 0xE0 ? 2 : lead < 0xF0 ? 3 : lead < 0xF5 ? 4 : 0;
    if (n == 0 || text.size() < n) return 0;
    const auto is_continuation = [](char c) { return (static_cast<unsigned char>(c) & 0xC0) == 0x80; };
    return std::all_of(text.begin() + 1, text.begin() + static_cast<std::ptrdiff_t>(n), is_continuation) ? n : 0;
}

/// `text` as a part of a line that a terminal or a JSON document can hold.
std::string printable(std::string_view text) {
    std::string line;
    while (!text.empty()) {
        const std::size_t n = utf8_length(text);
        const bool is_control = static_cast<unsigned char>(text.front()) < 0x20 || text.front() == 0x7F;
        if (line.size() + n > max_part_bytes) return line + "...";
        line += n == 0 || is_control ? std::string_view("?") : text.substr(0, n);
        text.remove_prefix(std::max<std::size_t>(n, 1));
    }
    return line;
}

/// A name is cut by itself, so that a long one does not push the sentence out.
Fault printable_fault(std::string file, const std::string& sentence) {
    constexpr std::size_t max_name_bytes = 120;
    if (file.size() > max_name_bytes) file = file.substr(0, max_name_bytes) + "...";
    return {printable(file), printable(sentence)};
}

std::string line_of(const Fault& fault) { return fault.file + ": " + fault.sentence; }

}  // namespace

void throw_fault(const std::string& file, const std::string& sentence) {
    throw InputError(line_of(printable_fault(file, sentence)));
}

void Faults::add(const std::string& file, const std::string& sentence) {
    faults_.push_back(printable_fault(file, sentence));
}

void Faults::append(const Faults& others) {
    faults_.insert(faults_.end(), others.faults_.begin(), others.faults_.end());
}

void Faults::throw_if_any() const {
    if (faults_.empty()) return;
    std::string message;
    const std::size_t n_shown = std::min(faults_.size(), max_lines);
    for (std::size_t i = 0; i < n_shown; ++i) message += (i > 0 ? "\n" : "") + line_of(faults_[i]);
    if (faults_.size() > n_shown) message += "\nand " + std::to_string(faults_.size() - n_shown) + " more faults";
    throw InputError(message);
}

}  // namespace anyrate
