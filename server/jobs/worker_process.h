#pragma once
#include <sys/types.h>

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "server/store/file.h"

namespace anyrate {

/// A child process whose standard output is read line by line. Destroying it kills the child and waits for its end.
class WorkerProcess {
public:
    /// @param command  program and arguments @throws IoError it cannot be started
    explicit WorkerProcess(const std::vector<std::string>& command);
    ~WorkerProcess();
    WorkerProcess(const WorkerProcess&) = delete;
    WorkerProcess& operator=(const WorkerProcess&) = delete;

    enum class Read { line, timeout, end };
    /// Waits up to `timeout` for the next whole line. A line beyond 64 KB ends the reading as a broken pipe would.
    Read read_line(std::string& line, std::chrono::milliseconds timeout);

    pid_t pid() const { return pid_; }
    void signal(int number) const;

    /// Waits for the end, after `patience` by force. @return how it ended, as a sentence: "exit status 1", "signal 9"
    std::string wait(std::chrono::milliseconds patience);

private:
    pid_t pid_ = -1;
    FileHandle output_;
    std::string buffer_;
};

}  // namespace anyrate
