#pragma once
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "server/jobs/capture_verdict.h"
#include "server/jobs/judgement_message.h"

namespace anyrate {

/// The command that starts a process which looks through an uploaded zip.
using JudgeCommand = std::function<std::vector<std::string>(const std::filesystem::path& zip)>;

/// In that process: looks through the zip and says so, message by message. Throws nothing but what `say` throws, and
/// IoError.
void say_judgement(const std::filesystem::path& zip, const std::function<void(const JudgementMessage&)>& say);

/// In the server: has the zip looked through by a process of its own, and gathers what that says. Its death costs the
/// upload, never the server.
/// @throws InputError the zip cannot be read, or is too much for the process's limits, with its sentence
/// @throws IoError    the process cannot be started, or the machine failed it
JudgedCapture judge_upload(const std::vector<std::string>& command);

}  // namespace anyrate
