#include "core/capture/faults.h"

#include <algorithm>
#include <cstddef>
#include <string_view>

#include "core/error.h"

namespace anyrate {
namespace {

constexpr std::size_t max_line_bytes = 400;
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

/// `text` in one line that a terminal or a JSON document can hold.
std::string printable(std::string_view text) {
    std::string line;
    while (!text.empty()) {
        const std::size_t n = utf8_length(text);
        const bool is_control = static_cast<unsigned char>(text.front()) < 0x20 || text.front() == 0x7F;
        if (line.size() + n > max_line_bytes) return line + "...";
        line += n == 0 || is_control ? std::string_view("?") : text.substr(0, n);
        text.remove_prefix(std::max<std::size_t>(n, 1));
    }
    return line;
}

std::string fault_line(const std::string& file, const std::string& sentence) {
    // The name is cut first, so that a long one does not push the sentence out.
    constexpr std::size_t max_name_bytes = 120;
    const std::string name = file.size() <= max_name_bytes ? file : file.substr(0, max_name_bytes) + "...";
    return printable(name + ": " + sentence);
}

}  // namespace

void throw_fault(const std::string& file, const std::string& sentence) { throw InputError(fault_line(file, sentence)); }

void Faults::add(const std::string& file, const std::string& sentence) { lines_.push_back(fault_line(file, sentence)); }

void Faults::append(const Faults& others) { lines_.insert(lines_.end(), others.lines_.begin(), others.lines_.end()); }

void Faults::throw_if_any() const {
    if (lines_.empty()) return;
    std::string message;
    const std::size_t n_shown = std::min(lines_.size(), max_lines);
    for (std::size_t i = 0; i < n_shown; ++i) message += (i > 0 ? "\n" : "") + lines_[i];
    if (lines_.size() > n_shown) message += "\nand " + std::to_string(lines_.size() - n_shown) + " more faults";
    throw InputError(message);
}

}  // namespace anyrate
