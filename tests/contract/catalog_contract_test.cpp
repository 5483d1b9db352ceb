// What every Catalog promises. Each implementation is a type with make(); a new one joins the list at the end.
#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#include <doctest/doctest.h>

#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "server/store/model_id.h"
#include "server/store/sqlite_catalog.h"
#include "tests/unit/server/temporary_folder.h"

using namespace anyrate;

namespace {

struct Sqlite {
    TemporaryFolder folder;
    std::unique_ptr<Catalog> make() { return std::make_unique<SqliteCatalog>(folder.path() / "catalog.sqlite"); }
};

Timestamp at(int milliseconds) { return Timestamp(std::chrono::milliseconds(milliseconds)); }

std::string add(Catalog& catalog, int time = 0, const std::string& key = "", const std::string& print = "") {
    return catalog
        .add({.id = new_model_id(),
              .options = {.n_vertices = 5000, .n_coarse = 700},
              .idempotency_key = key,
              .request_fingerprint = print},
             at(time))
        .id;
}

}  // namespace

TEST_CASE_TEMPLATE("Catalog: a new model is queued with its options", Implementation, Sqlite) {
    Implementation place;
    const auto catalog = place.make();
    const std::string id = add(*catalog, 7);
    const auto model = catalog->find(id);
    REQUIRE(model);
    CHECK(model->state == ModelState::queued);
    CHECK(model->options == ModelOptions{5000, 700});
    CHECK(model->attempts == 0);
    CHECK(model->created == at(7));
    CHECK_FALSE(catalog->find(new_model_id()));
}

TEST_CASE_TEMPLATE("Catalog: what was acknowledged is there after it is opened again", Implementation, Sqlite) {
    Implementation place;
    const std::string id = add(*place.make());
    CHECK(place.make()->find(id));
}

TEST_CASE_TEMPLATE("Catalog: models are claimed in their order, each once", Implementation, Sqlite) {
    Implementation place;
    const auto catalog = place.make();
    const std::string first = add(*catalog), second = add(*catalog);
    CHECK(catalog->claim_next(at(1))->id == first);
    CHECK(catalog->claim_next(at(1))->id == second);
    CHECK_FALSE(catalog->claim_next(at(1)));
    CHECK(catalog->find(first)->state == ModelState::running);
    CHECK(catalog->find(first)->attempts == 1);
}

TEST_CASE_TEMPLATE("Catalog: many claimers never get the same model", Implementation, Sqlite) {
    Implementation place;
    const auto catalog = place.make();
    for (int i = 0; i < 20; ++i) add(*catalog);
    std::vector<int> claimed(4);
    {
        std::vector<std::jthread> threads;
        for (int& n : claimed)
            threads.emplace_back([&] {
                while (catalog->claim_next(at(1))) ++n;
            });
    }
    CHECK(claimed[0] + claimed[1] + claimed[2] + claimed[3] == 20);
}

TEST_CASE_TEMPLATE("Catalog: progress and curve belong to the running attempt", Implementation, Sqlite) {
    Implementation place;
    const auto catalog = place.make();
    const std::string id = add(*catalog);
    const JobProgress progress{"refine", 0.5, 700, 9000, 12.5};
    const RatePoint point{700, 9000, 12.5, 1.25};
    catalog->report(id, progress, at(1));  // nobody runs it yet
    catalog->add_rate_point(id, point);
    CHECK(catalog->find(id)->progress == JobProgress{});
    CHECK(catalog->curve(id).empty());

    catalog->claim_next(at(2));
    catalog->report(id, progress, at(3));
    catalog->add_rate_point(id, point);
    CHECK(catalog->find(id)->progress == progress);
    CHECK(catalog->find(id)->updated == at(3));
    CHECK(catalog->curve(id) == std::vector<RatePoint>{point});

    catalog->retry(id, 3, "", at(4));
    catalog->claim_next(at(5));
    CHECK(catalog->find(id)->progress == JobProgress{});
    CHECK(catalog->curve(id).empty());
}

TEST_CASE_TEMPLATE("Catalog: a finished model stays as it is", Implementation, Sqlite) {
    Implementation place;
    const auto catalog = place.make();
    const std::string id = add(*catalog);
    catalog->claim_next(at(1));
    catalog->finish(id, ModelState::failed, "no cameras", at(2));
    catalog->finish(id, ModelState::done, "", at(3));
    catalog->retry(id, 3, "", at(3));
    CHECK(catalog->recover(3, "", at(4)) == 0);
    CHECK(catalog->find(id)->state == ModelState::failed);
    CHECK(catalog->find(id)->error == "no cameras");
}

TEST_CASE_TEMPLATE("Catalog: attempts are limited, what is given back does not count", Implementation, Sqlite) {
    Implementation place;
    const auto catalog = place.make();
    const std::string id = add(*catalog);
    catalog->claim_next(at(1));
    catalog->give_back(id, at(1));
    CHECK(catalog->find(id)->attempts == 0);
    catalog->claim_next(at(1));
    catalog->retry(id, 2, "died", at(1));
    CHECK(catalog->find(id)->state == ModelState::queued);
    catalog->claim_next(at(1));
    CHECK(catalog->recover(2, "died", at(1)) == 1);
    CHECK(catalog->find(id)->state == ModelState::failed);
    CHECK(catalog->find(id)->error == "died");
}

TEST_CASE_TEMPLATE("Catalog: an idempotency key stands for one request", Implementation, Sqlite) {
    Implementation place;
    const auto catalog = place.make();
    const std::string id = add(*catalog, 0, "key", "print");
    const NewModel again{new_model_id(), {}, "key", "print"}, other{new_model_id(), {}, "key", "other"};
    const Added repeated = catalog->add(again, at(1));
    CHECK(repeated.kind == Added::Kind::repeated);
    CHECK(repeated.id == id);
    CHECK(catalog->add(other, at(1)).kind == Added::Kind::key_reused);
    CHECK(catalog->list(10, "").models.size() == 1);
}

TEST_CASE_TEMPLATE("Catalog: pages go from the newest to the oldest", Implementation, Sqlite) {
    Implementation place;
    const auto catalog = place.make();
    const std::string a = add(*catalog), b = add(*catalog), c = add(*catalog);
    const ModelPage first = catalog->list(2, "");
    REQUIRE(first.models.size() == 2);
    CHECK(first.models[0].id == c);
    CHECK(first.models[1].id == b);
    CHECK(first.more);
    const ModelPage second = catalog->list(2, b);
    REQUIRE(second.models.size() == 1);
    CHECK(second.models[0].id == a);
    CHECK_FALSE(second.more);
    CHECK(catalog->list(2, new_model_id()).models.empty());
}

TEST_CASE_TEMPLATE("Catalog: a removed model is forgotten in every state", Implementation, Sqlite) {
    Implementation place;
    const auto catalog = place.make();
    const std::string id = add(*catalog, 0, "key");
    catalog->claim_next(at(1));
    CHECK(catalog->remove(id));
    CHECK_FALSE(catalog->remove(id));
    catalog->report(id, {}, at(2));
    catalog->finish(id, ModelState::done, "", at(2));
    CHECK_FALSE(catalog->find(id));
    CHECK(catalog->curve(id).empty());
}
