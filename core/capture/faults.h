#pragma once
#include <string>
#include <vector>

namespace anyrate {

/// Throws the InputError of a single fault that leaves nothing to go on with; see Faults::add().
[[noreturn]] void throw_fault(const std::string& file, const std::string& sentence);

/// What is wrong with a file: what was found and what was expected.
struct Fault {
    std::string file;  ///< name inside the capture
    std::string sentence;
};

/// Gathers what is wrong with a capture, so that its owner learns of every fault at once.
class Faults {
public:
    /// Adds a sentence about `file`, a name inside the capture: what was found and what was expected.
    /// Neither needs to be trusted: what is not printable becomes '?', and the line is cut to a sane length.
    void add(const std::string& file, const std::string& sentence);
    void append(const Faults& others);

    bool empty() const { return faults_.empty(); }
    const std::vector<Fault>& all() const { return faults_; }

    /// @throws InputError with one fault a line, if there is one; of very many, the first hundred and a count of the
    /// rest
    void throw_if_any() const;

private:
    std::vector<Fault> faults_;
};

}  // namespace anyrate
