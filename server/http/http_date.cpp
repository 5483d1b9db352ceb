#include "server/http/http_date.h"

#include <ctime>

namespace anyrate {

const std::string& http_date() {
    thread_local std::time_t made = 0;
    thread_local std::string date;
    const std::time_t now = std::time(nullptr);
    if (now != made) {
        std::tm utc{};
        ::gmtime_r(&now, &utc);
        char text[40];
        std::strftime(text, sizeof text, "%a, %d %b %Y %H:%M:%S GMT", &utc);
        date = text;
        made = now;
    }
    return date;
}

}  // namespace anyrate
