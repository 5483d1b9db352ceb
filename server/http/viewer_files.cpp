#include "server/http/viewer_files.h"

#include <string_view>
#include <utility>

#include "server/http/problem.h"
#include "server/store/file.h"

namespace anyrate {
namespace {

/// Nothing but this server's own files; WebAssembly (Draco) may be compiled, no text becomes code.
constexpr const char* content_security_policy =
    "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; style-src 'self'; img-src 'self' blob: data:; "
    "font-src 'self'; connect-src 'self'; worker-src 'self'; manifest-src 'self'; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'none'";

constexpr std::pair<std::string_view, const char*> content_types[] = {{".html", "text/html; charset=utf-8"},
                                                                      {".js", "text/javascript; charset=utf-8"},
                                                                      {".css", "text/css; charset=utf-8"},
                                                                      {".wasm", "application/wasm"},
                                                                      {".woff2", "font/woff2"},
                                                                      {".svg", "image/svg+xml"},
                                                                      {".png", "image/png"},
                                                                      {".txt", "text/plain; charset=utf-8"}};

const char* content_type_of(std::string_view name) {
    for (const auto& [suffix, type] : content_types)
        if (name.ends_with(suffix)) return type;
    return "application/octet-stream";
}

bool accepts(const Request& request, std::string_view coding) {
    const std::string_view accepted = request.headers.find("Accept-Encoding").value_or("");
    for (std::size_t at = accepted.find(coding); at != std::string_view::npos; at = accepted.find(coding, at + 1)) {
        const std::string_view rest = accepted.substr(at + coding.size());
        const bool starts = at == 0 || accepted[at - 1] == ' ' || accepted[at - 1] == ',';
        if (starts && (rest.empty() || rest[0] == ',')) return true;
    }
    return false;
}

Response file_of(const std::map<std::string, std::string>& files, const Request& request, const std::string& name) {
    const auto plain = files.find(name);
    if (plain == files.end()) throw HttpProblem(404, "there is no " + request.path);
    Response response;
    response.headers = {{"Content-Type", content_type_of(name)}, {"Vary", "Accept-Encoding"}};
    for (const auto& [coding, suffix] : {std::pair("br", ".br"), std::pair("gzip", ".gz")}) {
        const auto packed = files.find(name + suffix);
        if (packed == files.end() || !accepts(request, coding)) continue;
        response.headers.add("Content-Encoding", coding);
        response.body = packed->second;
        return response;
    }
    response.body = plain->second;
    return response;
}

}  // namespace

std::shared_ptr<const ViewerFiles> ViewerFiles::load(const std::filesystem::path& folder) {
    if (!std::filesystem::is_regular_file(folder / "index.html")) return nullptr;
    auto viewer = std::make_shared<ViewerFiles>();
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
        if (!entry.is_regular_file()) continue;
        const std::string name = entry.path().lexically_relative(folder).generic_string();
        viewer->files_[name] = std::string(as_text(read_file(entry.path())));
    }
    return viewer;
}

Response ViewerFiles::page(const Request& request) const {
    Response response = file_of(files_, request, "index.html");
    response.headers.add("Cache-Control", "no-cache");
    response.headers.add("Content-Security-Policy", content_security_policy);
    response.headers.add("Referrer-Policy", "no-referrer");
    return response;
}

Response ViewerFiles::asset(const Request& request, const std::string& name) const {
    Response response = file_of(files_, request, "assets/" + name);
    response.headers.add("Cache-Control", "public, max-age=31536000, immutable");
    return response;
}

}  // namespace anyrate
