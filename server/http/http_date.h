#pragma once
#include <string>

namespace anyrate {

/// The Date field's value now; made once a second on each thread.
const std::string& http_date();

}  // namespace anyrate
