#include "server/cli/config_file.h"

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace anyrate {
namespace {

void take(CLI::Option& option, const CLI::ConfigItem& item) {
    if (!option.empty()) return;
    const bool is_flag = option.get_expected_min() == 0;
    if (is_flag)
        option.add_result(option.get_flag_value(item.name, CLI::ConfigTOML().to_flag(item)));
    else
        option.add_result(item.inputs);
    option.run_callback();
}

}  // namespace

void read_config_file(CLI::App& command, const std::filesystem::path& file) {
    for (const CLI::ConfigItem& item : CLI::ConfigTOML().from_file(file.string())) {
        CLI::Option* option = item.parents.empty() ? command.get_option_no_throw("--" + item.name) : nullptr;
        if (!option || !option->get_configurable())
            throw CLI::ConfigError(file.string() + ": \"" + item.fullname() + "\" is no option of " +
                                       command.get_name() + "; expected names as " + command.get_name() +
                                       " --help has them, without dashes",
                                   CLI::ExitCodes::ConfigError);
        take(*option, item);
    }
}

}  // namespace anyrate
