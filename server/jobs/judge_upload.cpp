#include "server/jobs/judge_upload.h"

#include <signal.h>

#include <chrono>
#include <new>
#include <optional>
#include <utility>

#include "core/error.h"
#include "server/jobs/worker_process.h"

namespace anyrate {
namespace {

/// The process's own limit is one of processor time; this is for one that waits for ever.
constexpr auto patience = std::chrono::minutes(5);
constexpr std::size_t max_messages = 100'000;

/// Puts the messages of a process together.
class Judgement {
public:
    void take(const JudgementMessage& message) {
        if (++n_messages_ > max_messages) throw IoError("a process that looks through an upload says too much");
        std::visit([this](const auto& m) { apply(m); }, message);
    }
    bool is_over() const { return is_over_; }
    JudgedCapture result() && { return std::move(judged_); }

private:
    void apply(const CaptureFile& file) { judged_.files.push_back(file); }
    void apply(const MissingFile& file) { judged_.verdict.missing.push_back(file.path); }
    void apply(const CaptureFault& fault) { judged_.verdict.refused.emplace_back(fault.path, fault.sentence); }
    void apply(const NotReadable& end) { throw InputError(end.sentence); }
    void apply(const JudgementEnd&) { is_over_ = true; }

    JudgedCapture judged_;
    std::size_t n_messages_ = 0;
    bool is_over_ = false;
};

/// Of a process that ended before it had said all. @param how  WorkerProcess::wait()
[[noreturn]] void throw_end(const std::string& how) {
    if (how == "signal " + std::to_string(SIGXCPU))
        throw InputError("capture.zip: takes too long to look through; expected photographs and cameras.json");
    // What else ends it from outside (want of memory, an operator) is not the upload's fault, as far as can be known.
    if (how == "signal " + std::to_string(SIGKILL) || how.starts_with("exit"))
        throw IoError("the process that looked through an upload ended with " + how);
    throw InputError("capture.zip: is damaged in a way that ended the process which looked through it (" + how + ")");
}

/// A line holds 64 KB, with every character escaped.
std::string shortened(const std::string& text) {
    constexpr std::size_t most = 4000;
    return text.size() <= most ? text : text.substr(0, most) + "...";
}

}  // namespace

void say_judgement(const std::filesystem::path& zip, const std::function<void(const JudgementMessage&)>& say) {
    try {
        const JudgedCapture judged = judge_zip(zip);
        for (CaptureFile file : judged.files) {
            file.path = shortened(file.path);
            file.fault = shortened(file.fault);
            say(file);
        }
        for (const std::string& path : judged.verdict.missing) say(MissingFile{shortened(path)});
        for (const auto& [path, sentence] : judged.verdict.refused)
            say(CaptureFault{shortened(path), shortened(sentence)});
        say(JudgementEnd{});
    } catch (const InputError& error) {
        say(NotReadable{shortened(error.what())});
    } catch (const std::bad_alloc&) {
        say(NotReadable{"capture.zip: needs more memory than a worker may use to be looked through"});
    }
}

JudgedCapture judge_upload(const std::vector<std::string>& command) {
    WorkerProcess process(command);
    Judgement judgement;
    const auto deadline = std::chrono::steady_clock::now() + patience;
    for (std::string line; !judgement.is_over();) {
        const auto read = process.read_line(line, std::chrono::milliseconds(500));
        if (read == WorkerProcess::Read::end) throw_end(process.wait(std::chrono::seconds(2)));
        try {
            if (read == WorkerProcess::Read::line) judgement.take(decode_judgement_message(line));
        } catch (const DecodeError& error) {
            throw IoError(error.what());
        }
        if (std::chrono::steady_clock::now() > deadline)
            throw IoError("the process that looks through an upload does not end");
    }
    return std::move(judgement).result();
}

}  // namespace anyrate
