#include "server/client/log_target.h"

#include <algorithm>
#include <string_view>

#include "server/store/model_id.h"

namespace anyrate {
namespace {

constexpr std::string_view models = "/v1/models/";

bool is_model_target(const std::string& target) {
    return std::string_view(target).substr(0, models.size()) == models &&
           is_model_id(std::string_view(target).substr(models.size()));
}

}  // namespace

std::string log_target(const std::string& target) { return is_model_target(target) ? target + "/log" : target; }

std::string index_target(const std::string& log_target) {
    constexpr std::string_view log = "/log";
    const auto model = log_target.size() - std::min(log_target.size(), log.size());
    if (log_target.substr(model) == log && is_model_target(log_target.substr(0, model)))
        return log_target.substr(0, model) + "/index?form=live";
    return log_target + ".idx";
}

}  // namespace anyrate
