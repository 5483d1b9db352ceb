#include "server/http/pages.h"

#include <cstdio>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>

#include "core/error.h"
#include "server/http/model_json.h"
#include "server/http/openapi_document.h"
#include "server/http/problem.h"

namespace anyrate {
namespace {

constexpr std::size_t max_models = 200;
constexpr ModelState all_states[] = {ModelState::queued, ModelState::running, ModelState::done, ModelState::failed,
                                     ModelState::cancelled};

constexpr const char* page_head = R"html(<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>Anyrate</title>
<style>
body { font: 16px/1.5 system-ui, sans-serif; max-width: 64rem; margin: 2rem auto; padding: 0 1rem; color: #222; }
h1 { font-weight: 600; }
table { border-collapse: collapse; width: 100%; }
th, td { text-align: left; padding: .45rem .8rem .45rem 0; border-bottom: 1px solid #ddd; vertical-align: top; }
td.number, th.number { text-align: right; font-variant-numeric: tabular-nums; }
code { font-size: .9em; }
.done { color: #17692c; } .failed { color: #a11; } .running { color: #1450a0; } .queued { color: #666; }
small { color: #666; display: block; }
</style>
</head>
<body>
<h1>Anyrate</h1>
<p>Models rebuilt from photographs, each one stream: any prefix of it is a valid mesh.
The interface is described in <a href="/openapi.yaml">openapi.yaml</a>.</p>
)html";

std::string escaped(std::string_view text) {
    std::string html;
    for (const char c : text) {
        switch (c) {
            case '&':
                html += "&amp;";
                break;
            case '<':
                html += "&lt;";
                break;
            case '>':
                html += "&gt;";
                break;
            case '"':
                html += "&quot;";
                break;
            default:
                html += c;
        }
    }
    return html;
}

std::string state_cell(const ModelRecord& model) {
    std::string cell = std::string("<span class=\"") + state_name(model.state) + "\">" + state_name(model.state);
    if (model.state == ModelState::running && !model.progress.stage.empty()) {
        char percent[16];
        std::snprintf(percent, sizeof percent, " %.0f %%", 100 * model.progress.fraction);
        cell += ": " + escaped(model.progress.stage) + percent;
    }
    cell += "</span>";
    if (!model.error.empty()) cell += "<small>" + escaped(model.error) + "</small>";
    return cell;
}

std::string links_cell(const ModelRecord& model) {
    if (model.progress.n_bytes == 0) return "";
    const std::string self = "/v1/models/" + model.id;
    std::string cell = "<a href=\"" + self + "/log\">log</a>";
    for (const char* format : {"ply", "obj", "glb"})
        cell += " &middot; <a href=\"" + self + "/mesh." + format + "\">" + format + "</a>";
    return cell;
}

void add_row(std::ostream& page, const ModelRecord& model) {
    page << "<tr><td><a href=\"/v1/models/" << model.id << "\"><code>" << model.id << "</code></a><small>"
         << iso_time(model.created) << "</small></td><td>" << state_cell(model) << "</td><td class=\"number\">"
         << model.progress.n_vertices << "</td><td class=\"number\">" << model.progress.n_bytes << "</td><td>"
         << links_cell(model) << "</td></tr>\n";
}

Response text_response(std::string text, const char* content_type) {
    return {.headers = {{"Content-Type", content_type}, {"Cache-Control", "no-store"}}, .body = std::move(text)};
}

}  // namespace

Response front_page(Service& service, const Request& request) {
    if (service.viewer) return service.viewer->page(request);
    const ModelPage models = service.catalog.list(max_models, Catalog::from_newest);
    std::ostringstream page;
    page << page_head;
    if (models.models.empty()) {
        page << "<p>There is no model yet. Make one: <code>anyrate push CAPTURE --server URL --wait</code></p>\n";
    } else {
        page << "<table>\n<tr><th>model</th><th>state</th><th class=\"number\">vertices</th>"
                "<th class=\"number\">bytes</th><th>downloads</th></tr>\n";
        for (const ModelRecord& model : models.models) add_row(page, model);
        page << "</table>\n";
    }
    if (models.more) page << "<p>The newest " << max_models << " are shown.</p>\n";
    page << "</body>\n</html>\n";
    Response response = text_response(page.str(), "text/html; charset=utf-8");
    response.headers.add("Content-Security-Policy", "default-src 'none'; style-src 'unsafe-inline'");
    return response;
}

Response viewer_asset(Service& service, const Request& request) {
    const std::string& name = request.captured.at("name");
    if (!service.viewer) throw HttpProblem(404, "this server has no viewer: build it with npm run viewer in web/");
    return service.viewer->asset(request, name);
}

Response healthz(const Request&) { return text_response("ok\n", "text/plain"); }

Response readyz(Service& service, const Request&) {
    try {
        service.catalog.list(1, Catalog::from_newest);
    } catch (const IoError& error) {
        throw HttpProblem(503, error.what());
    }
    if (service.store.free_bytes() < service.min_free_bytes)
        throw HttpProblem(503, "the disk of the data directory is full");
    try {
        service.store.try_to_write();
    } catch (const IoError&) {  // its sentence names a path of this machine
        throw HttpProblem(503, "nothing can be written in the data directory");
    }
    return text_response("ready\n", "text/plain");
}

Response show_metrics(Service& service, const Request&) {
    std::string text = to_prometheus(service.metrics);
    write_metric(text, "anyrate_free_bytes", "gauge", "Bytes that are free on the disk of the data directory.",
                 static_cast<double>(service.store.free_bytes()));
    text += "# HELP anyrate_models Models by state.\n# TYPE anyrate_models gauge\n";
    const auto counts = service.catalog.counts();
    for (const ModelState state : all_states) {
        const auto found = counts.find(state);  // one that no model is in has a line, too, so that it can be watched
        const auto n = found == counts.end() ? 0 : found->second;
        text += std::string("anyrate_models{state=\"") + state_name(state) + "\"} " + std::to_string(n) + "\n";
    }
    return text_response(std::move(text), "text/plain; version=0.0.4");
}

Response openapi_yaml(const Request&) { return text_response(std::string(openapi_document()), "application/yaml"); }

Response openapi_json(const Request&) {
    return text_response(std::string(openapi_document_json()), "application/json");
}

}  // namespace anyrate
