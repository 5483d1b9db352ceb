#include "server/client/url.h"

#include <algorithm>

#include "core/error.h"

namespace anyrate {
namespace {

constexpr std::string_view plain = "http://", secure = "https://";

bool is_port(std::string_view text) {
    return !text.empty() && text.size() <= 5 &&
           std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
}

}  // namespace

std::string Url::authority() const {
    const std::string name = host.find(':') == std::string::npos ? host : "[" + host + "]";
    return port == (is_secure ? "443" : "80") ? name : name + ":" + port;
}

Url parse_url(std::string_view text) {
    const auto refuse = [&](const std::string& why) { throw InputError("\"" + std::string(text) + "\": " + why); };
    const bool is_secure = text.starts_with(secure);
    if (!is_secure && !text.starts_with(plain)) refuse("expected an address that begins with http:// or https://");
    std::string_view rest = text.substr((is_secure ? secure : plain).size());
    rest = rest.substr(0, rest.find('#'));
    const auto end = std::min(rest.find_first_of("/?"), rest.size());
    std::string_view authority = rest.substr(0, end);
    const std::string_view target = rest.substr(end);

    Url url{.is_secure = is_secure, .host = {}, .port = is_secure ? "443" : "80"};
    if (authority.find('@') != std::string_view::npos) refuse("an address with a user name is not supported");
    const auto bracket = authority.find(']');
    const auto colon = authority.find(':', bracket == std::string_view::npos ? 0 : bracket);
    if (colon != std::string_view::npos) {
        url.port = authority.substr(colon + 1);
        authority = authority.substr(0, colon);
        if (!is_port(url.port)) refuse("expected a number behind the colon");
    }
    if (!authority.empty() && authority.front() == '[' && authority.back() == ']')
        authority = authority.substr(1, authority.size() - 2);
    if (authority.empty()) refuse("there is no host in it");
    url.host = authority;
    url.target = target;
    if (url.target.empty() || url.target.front() == '?') url.target.insert(url.target.begin(), '/');
    return url;
}

std::string path_of(const Url& url) { return url.target.substr(0, url.target.find('?')); }

}  // namespace anyrate
