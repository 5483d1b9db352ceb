#include "server/store/capture_store.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>

#include "core/error.h"
#include "server/store/file.h"
#include "server/store/model_id.h"

namespace anyrate {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

template <class Work>
auto io(const Work& work) {
    try {
        return work();
    } catch (const fs::filesystem_error& error) {
        if (error.code() == std::errc::no_space_on_device) throw DiskFull(error.what());
        throw IoError(error.what());
    }
}

json to_json(const CaptureFile& file) {
    return {{"path", file.path}, {"bytes", file.n_bytes}, {"sha256", file.sha256}, {"fault", file.fault},
            {"kind", file.kind}, {"width", file.width},   {"height", file.height}};
}

CaptureFile file_from(const json& entry) {
    return {.path = entry.at("path"),
            .n_bytes = entry.at("bytes"),
            .sha256 = entry.at("sha256"),
            .fault = entry.at("fault"),
            .kind = entry.at("kind"),
            .width = entry.at("width"),
            .height = entry.at("height")};
}

bool comes_before(const CaptureFile& a, const CaptureFile& b) { return a.path < b.path; }

}  // namespace

std::uint64_t CaptureRecord::n_bytes() const {
    std::uint64_t n = 0;
    for (const CaptureFile& file : files) n += file.n_bytes;
    return n;
}

CaptureStore::CaptureStore(const fs::path& data) : root_(data / "captures") {
    io([&] { fs::create_directories(root_); });
}

fs::path CaptureStore::folder(const std::string& id) const {
    if (!is_model_id(id)) throw InputError("\"" + id + "\" is not the id of a capture: expected 26 of a-z and 2-7");
    return root_ / id;
}

bool CaptureStore::is_there(const std::string& id) const {
    return is_model_id(id) && io([&] { return fs::exists(folder(id) / "files.json"); });
}

std::shared_ptr<std::shared_mutex> CaptureStore::mutex_of(const std::string& id) {
    const std::lock_guard lock(mutex_);
    if (const auto known = mutexes_.find(id); known != mutexes_.end())
        if (auto mutex = known->second.lock()) return mutex;
    std::erase_if(mutexes_, [](const auto& entry) { return entry.second.expired(); });
    auto mutex = std::make_shared<std::shared_mutex>();
    mutexes_[id] = mutex;
    return mutex;
}

CaptureRecord CaptureStore::create(const std::string& id, Timestamp now) {
    const auto mutex = mutex_of(id);
    const std::lock_guard lock(*mutex);
    if (is_there(id)) return read(id);
    const CaptureRecord capture{.id = id, .created = now, .files = {}};
    io([&] { fs::create_directories(folder(id) / "files"); });
    write(capture);
    sync_folder(root_);
    return capture;
}

std::optional<CaptureRecord> CaptureStore::find(const std::string& id) {
    const auto mutex = mutex_of(id);
    const std::shared_lock lock(*mutex);
    if (!is_there(id)) return std::nullopt;
    return read(id);
}

CapturePage CaptureStore::list(std::size_t limit, const std::string& after) {
    std::vector<std::string> ids;
    io([&] {
        for (const auto& entry : fs::directory_iterator(root_))
            if (const std::string id = entry.path().filename().string(); is_model_id(id) && id > after)
                ids.push_back(id);
    });
    std::sort(ids.begin(), ids.end());
    CapturePage page;
    for (const std::string& id : ids) {
        auto capture = find(id);
        if (!capture) continue;  // removed meanwhile
        page.more = page.captures.size() == limit;
        if (page.more) break;
        page.captures.push_back(std::move(*capture));
    }
    return page;
}

bool CaptureStore::put(const std::string& id, const CaptureFile& file, const fs::path& upload) {
    const auto mutex = mutex_of(id);
    const std::lock_guard lock(*mutex);
    if (!is_there(id)) return false;
    CaptureRecord capture = read(id);
    auto at = std::lower_bound(capture.files.begin(), capture.files.end(), file, comes_before);
    if (at != capture.files.end() && at->path == file.path) {
        // A crash between here and the end leaves no list that speaks of the earlier bytes.
        at = capture.files.erase(at);
        write(capture);
    }
    const fs::path place = folder(id) / "files" / file.path;
    const bool is_new_folder = io([&] { return fs::create_directories(place.parent_path()); });
    io([&] { fs::rename(upload, place); });
    sync_folder(place.parent_path());
    if (is_new_folder) sync_folder(folder(id) / "files");
    capture.files.insert(at, file);
    write(capture);
    return true;
}

bool CaptureStore::remove(const std::string& id) {
    const auto mutex = mutex_of(id);
    const std::lock_guard lock(*mutex);
    if (!is_there(id)) return false;
    io([&] {
        fs::remove(folder(id) / "files.json");  // first, so that a crash leaves no capture with half its files
        fs::remove_all(folder(id));
    });
    return true;
}

int CaptureStore::remove_older(Timestamp time) {
    int n_removed = 0;
    for (const auto& entry : io([&] { return std::vector<fs::path>{fs::directory_iterator(root_), {}}; })) {
        const std::string id = entry.filename().string();
        if (!is_model_id(id)) continue;
        const auto mutex = mutex_of(id);
        const std::lock_guard lock(*mutex);
        // What a crash left of one has no list.
        if (is_there(id) && read(id).created >= time) continue;
        io([&] {
            fs::remove(folder(id) / "files.json");
            fs::remove_all(folder(id));
        });
        ++n_removed;
    }
    return n_removed;
}

CaptureRecord CaptureStore::read(const std::string& id) const {
    const auto bytes = read_file(folder(id) / "files.json");
    try {
        const json document = json::parse(as_text(bytes));
        CaptureRecord capture{
            .id = id,
            .created = Timestamp(std::chrono::milliseconds(document.at("created").get<std::int64_t>())),
            .files = {}};
        for (const json& entry : document.at("files")) capture.files.push_back(file_from(entry));
        return capture;
    } catch (const json::exception& error) {
        throw IoError("the list of capture " + id + " is damaged: " + error.what());
    }
}

void CaptureStore::write(const CaptureRecord& capture) const {
    json document = {{"created", capture.created.time_since_epoch().count()}, {"files", json::array()}};
    for (const CaptureFile& file : capture.files) document["files"].push_back(to_json(file));
    const std::string text = document.dump(-1, ' ', false, json::error_handler_t::replace) + "\n";
    replace_file(folder(capture.id) / "files.json", as_bytes(text));
}

}  // namespace anyrate
