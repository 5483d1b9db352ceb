// What every LogStore promises. Each implementation is a type with make() and an id() that it may hold; a new one joins
// the list of every test.
#include <doctest/doctest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "proto/header.h"
#include "proto/log_reader.h"
#include "proto/log_writer.h"
#include "server/store/directory_log_store.h"
#include "server/store/model_store.h"
#include "tests/unit/server/small_model.h"
#include "tests/unit/server/temporary_folder.h"

using namespace anyrate;

namespace {

struct Directory {
    TemporaryFolder folder;
    std::unique_ptr<LogStore> make() { return std::make_unique<DirectoryLogStore>(folder.path()); }
    std::string id() {
        const std::string id = new_model_id();
        std::filesystem::create_directories(model_paths(folder.path(), id).folder);
        return id;
    }
};

constexpr std::uint64_t log_id = 7;

/// The parts of a small log: header with base, then one per frame; and its rows.
struct Parts {
    std::vector<std::vector<std::byte>> frames;
    std::vector<IndexRow> rows;

    Parts() {
        LogWriter writer(log_id,
                         [this](std::span<const std::byte> bytes) { frames.emplace_back(bytes.begin(), bytes.end()); });
        write_small_model(writer, 3);
        rows.assign(writer.rows().begin(), writer.rows().end());
    }
    std::vector<std::byte> whole() const {
        std::vector<std::byte> all;
        for (const auto& frame : frames) all.insert(all.end(), frame.begin(), frame.end());
        return all;
    }
};
const Parts& parts() {
    static const Parts log;
    return log;
}

void write_all(LogAppender& log) {
    for (const auto& frame : parts().frames) log.append(frame);
    log.publish_index(log_id, parts().rows);
}

}  // namespace

TEST_CASE_TEMPLATE("Log store: a new log is empty, and there is nothing to read", Implementation, Directory) {
    Implementation place;
    const auto store = place.make();
    const std::string id = place.id();
    const auto log = store->take(id, 1);
    CHECK(log->read().empty());
    CHECK_FALSE(log->read_index());
    CHECK_FALSE(log->note("mark"));
    CHECK_FALSE(store->open_log(id));
    CHECK_FALSE(store->open_live_log(id));
}

TEST_CASE_TEMPLATE("Log store: readers see frames when their rows are published, not before", Implementation,
                   Directory) {
    Implementation place;
    const auto store = place.make();
    const std::string id = place.id();
    const auto log = store->take(id, 1);
    for (const auto& frame : parts().frames) log->append(frame);
    CHECK_FALSE(store->open_log(id));
    log->publish_index(log_id, std::span(parts().rows).first(2));
    const LogView view = store->open_log(id).value();
    CHECK(view.rows.size() == 2);
    CHECK(view.size == view.frames_begin + parts().rows[1].end);
    CHECK(view.log_id == log_id);
    CHECK_FALSE(view.complete);
    const auto whole = parts().whole();
    CHECK(std::ranges::equal(read_at(*view.file, 0, view.size), std::span(whole).first(view.size)));
}

TEST_CASE_TEMPLATE("Log store: what was appended is there for the next writer, notes too", Implementation, Directory) {
    Implementation place;
    const std::string id = place.id();
    {
        const auto log = place.make()->take(id, 1);
        write_all(*log);
        log->keep_note("mark", as_bytes("first"));
        log->keep_note("mark", as_bytes("here"));
        log->keep_note("other", as_bytes(""));
    }
    const auto log = place.make()->take(id, 2);
    CHECK(log->read() == parts().whole());
    CHECK(log->read_index()->rows == parts().rows);
    CHECK(as_text(log->note("mark").value()) == "here");
    CHECK(log->note("other")->empty());
    log->drop_note("mark");
    log->drop_note("never was");
    CHECK_FALSE(log->note("mark"));
}

TEST_CASE_TEMPLATE("Log store: who has lost the lease changes nothing, whatever he tries", Implementation, Directory) {
    Implementation place;
    const auto store = place.make(), elsewhere = place.make();
    const std::string id = place.id();
    const auto lost = store->take(id, 1);
    write_all(*lost);
    lost->keep_note("mark", as_bytes("here"));
    const auto held = elsewhere->take(id, 2);
    CHECK_THROWS_AS(lost->append(parts().frames.back()), LeaseLost);
    CHECK_THROWS_AS(lost->begin_anew(), LeaseLost);
    CHECK_THROWS_AS(lost->cut(0), LeaseLost);
    CHECK_THROWS_AS(lost->publish_index(9, {}), LeaseLost);
    CHECK_THROWS_AS(lost->seal(parts().rows), LeaseLost);
    CHECK_THROWS_AS(lost->keep_note("mark", as_bytes("there")), LeaseLost);
    CHECK_THROWS_AS(lost->drop_note("mark"), LeaseLost);
    CHECK_THROWS_AS(store->take(id, 1), LeaseLost);
    CHECK(held->read() == parts().whole());
    CHECK(held->read_index()->log_id == log_id);
    CHECK(as_text(held->note("mark").value()) == "here");
    CHECK_FALSE(store->open_log(id)->sealed);
    CHECK_NOTHROW(held->append(parts().frames.back()));
}

TEST_CASE_TEMPLATE("Log store: of writers in several processes with several leases the frames are never mixed",
                   Implementation, Directory) {
    Implementation place;
    const std::string id = place.id();
    place.make()->take(id, 1)->append(parts().frames[0]);
    constexpr int n_writers = 6, n_appends = 200;
    const std::vector<std::byte> frame(64);
    std::vector<pid_t> children;
    for (int w = 0; w < n_writers; ++w) {
        const pid_t child = ::fork();
        if (child == 0) {  // each a later lease than the one before, all at the same time
            int status = 0;
            try {
                const auto log = place.make()->take(id, static_cast<std::uint64_t>(2 + w));
                for (int i = 0; i < n_appends; ++i)
                    log->append(std::vector<std::byte>(64, static_cast<std::byte>(1 + w)));
            } catch (const LeaseLost&) {
                status = 1;
            }
            ::_exit(status);
        }
        children.push_back(child);
    }
    int n_unrefused = 0;
    for (const pid_t child : children) {
        int status = 0;
        ::waitpid(child, &status, 0);
        n_unrefused += WEXITSTATUS(status) == 0 ? 1 : 0;
    }
    CHECK(n_unrefused >= 1);
    const auto bytes = place.make()->take(id, 100)->read();
    const auto body = std::span(bytes).subspan(parts().frames[0].size());
    REQUIRE(body.size() % 64 == 0);
    // Leases only grow along the log: nobody wrote after a later one had begun.
    CHECK(std::ranges::is_sorted(body));
    CHECK(std::ranges::count(body, static_cast<std::byte>(n_writers)) == 64 * n_appends);  // the last is never refused
}

TEST_CASE_TEMPLATE("Log store: a log is begun anew without harm to who reads the old one", Implementation, Directory) {
    Implementation place;
    const auto store = place.make();
    const std::string id = place.id();
    const auto log = store->take(id, 1);
    write_all(*log);
    const LogView old = store->open_log(id).value();
    log->begin_anew();
    CHECK_FALSE(store->open_log(id));
    CHECK(log->read().empty());
    log->append(parts().frames[0]);
    const auto whole = parts().whole();
    CHECK(std::ranges::equal(read_at(*old.file, 0, old.size), std::span(whole).first(old.size)));
}

TEST_CASE_TEMPLATE("Log store: what stands behind the last row can be cut", Implementation, Directory) {
    Implementation place;
    const auto store = place.make();
    const std::string id = place.id();
    const auto log = store->take(id, 1);
    write_all(*log);
    log->append(as_bytes("half a fra"));
    log->cut(parts().whole().size());
    CHECK(log->read() == parts().whole());
    log->append(parts().frames.back());
    CHECK(log->read().size() == parts().whole().size() + parts().frames.back().size());
}

TEST_CASE_TEMPLATE("Log store: a sealed log is what is read, the live one stays for who follows it", Implementation,
                   Directory) {
    Implementation place;
    const auto store = place.make();
    const std::string id = place.id();
    const auto log = store->take(id, 1);
    write_all(*log);
    log->seal(parts().rows);
    const LogView sealed = store->open_log(id).value(), live = store->open_live_log(id).value();
    CHECK(sealed.sealed);
    CHECK(sealed.complete);
    CHECK(verify_log(read_at(*sealed.file, 0, sealed.size)) > 0);
    CHECK_FALSE(live.sealed);
    CHECK(live.complete);
    CHECK(read_at(*live.file, 0, live.size) == parts().whole());
}

TEST_CASE_TEMPLATE("Log store: what is not shaped like a model id is refused", Implementation, Directory) {
    Implementation place;
    const auto store = place.make();
    for (const char* id :
         {"", "..", "../../etc/passwd", "a", "AAAAAAAAAAAAAAAAAAAAAAAAAA", "aaaaaaaaaaaaaaaaaaaaaaaaa/"}) {
        CHECK_THROWS_AS(store->take(id, 1), InputError);
        CHECK_THROWS_AS(store->open_log(id), InputError);
        CHECK_THROWS_AS(store->open_live_log(id), InputError);
    }
}
