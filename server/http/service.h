#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "server/http/hot_logs.h"
#include "server/http/metrics.h"
#include "server/http/router.h"
#include "server/http/viewer_files.h"
#include "server/jobs/capture_verdict.h"
#include "server/store/capture_store.h"
#include "server/store/catalog.h"
#include "server/store/model_store.h"

namespace anyrate {

/// What the handlers work on.
struct Service {
    Catalog& catalog;
    ModelStore& store;
    CaptureStore& captures;
    HotLogs& hot_logs;
    Metrics& metrics;
    std::function<void()> on_queued;                        ///< a model is in the queue
    std::function<void(const std::string& id)> on_removed;  ///< a model is gone from the catalog: end its worker
    /// Looks through a zip before a job is made of it, in a process of its own; empty: that is left to the job.
    /// @throws InputError it is no sound zip @throws IoError
    std::function<JudgedCapture(const std::filesystem::path& zip)> judge_zip = {};
    std::uint64_t max_capture_bytes = 1ull << 30;    ///< of all files of one that comes file by file
    std::uint64_t min_free_bytes = 64u << 20;        ///< below this the server is not ready and takes no upload
    std::shared_ptr<const ViewerFiles> viewer = {};  ///< nullptr: a plain page in its place
};

/// Every route of the HTTP interface. `service` must outlive it.
Router make_router(Service& service);

/// Routes and answers one request without a socket; never throws: an exception becomes its problem document.
Response answer(const Router& router, Request request);

}  // namespace anyrate
