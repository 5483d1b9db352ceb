// What every Catalog promises. Each implementation is a type with make(); a new one joins the list at the end.
#include <doctest/doctest.h>

#include <map>
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

Lease claim(Catalog& catalog, int time = 1) { return lease_of(catalog.claim_next(at(time)).value()); }

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

TEST_CASE_TEMPLATE("Catalog: models whose server dies share what attempts there are", Implementation, Sqlite) {
    Implementation place;
    const auto catalog = place.make();
    const std::string first = add(*catalog), second = add(*catalog), third = add(*catalog);
    const RetryRule rule{.max_fruitless = 20};
    std::map<std::string, int> n_attempts;
    for (int time = 1; time <= 30; ++time) {  // the server is killed before any attempt gets further
        ++n_attempts[claim(*catalog, time).id];
        CHECK(catalog->recover(Timestamp::max(), rule, "too often", at(time)) == 1);
    }
    CHECK(n_attempts == std::map<std::string, int>{{first, 10}, {second, 10}, {third, 10}});
    const Lease lease = claim(*catalog, 31);  // one that gets further goes before the others again
    CHECK(lease.id == first);
    catalog->add_rate_point(lease, {700, 9000, 12.5, 1.25});
    catalog->recover(Timestamp::max(), rule, "too often", at(32));
    CHECK(claim(*catalog, 33).id == first);
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
    const JobProgress progress{"refine", 0.5, 700, 9000, 12.5, 60.0};
    const RatePoint point{700, 9000, 12.5, 1.25};
    CHECK_FALSE(catalog->report({id, 0}, progress, at(1)));  // nobody runs it yet
    CHECK_FALSE(catalog->add_rate_point({id, 0}, point));
    CHECK(catalog->find(id)->progress == JobProgress{});
    CHECK(catalog->curve(id).empty());

    const Lease lease = claim(*catalog, 2);
    CHECK(catalog->report(lease, progress, at(3)));
    CHECK(catalog->add_rate_point(lease, point));
    CHECK(catalog->find(id)->progress == progress);
    CHECK(catalog->find(id)->updated == at(3));
    CHECK(catalog->curve(id) == std::vector<RatePoint>{point});
}

TEST_CASE_TEMPLATE("Catalog: an attempt keeps the curve as far as it goes on with the log", Implementation, Sqlite) {
    Implementation place;
    const auto catalog = place.make();
    const std::string id = add(*catalog);
    const RatePoint first{700, 9000, 12.5, 1.25}, second{900, 12000, 11.5, 2.5};
    const Lease lease = claim(*catalog);
    for (const RatePoint& point : {first, second}) catalog->add_rate_point(lease, point);
    catalog->report(lease, {"refine", 0.9, 900, 12000, 11.5}, at(3));
    catalog->retry(lease, {}, "", at(4));

    const Lease next = claim(*catalog, 5);
    CHECK(catalog->curve(id) == std::vector<RatePoint>{first, second});
    CHECK(catalog->begin(next, 9000, at(6)));
    CHECK(catalog->curve(id) == std::vector<RatePoint>{first});
    CHECK(catalog->find(id)->progress == JobProgress{"", 0, 700, 9000, 12.5});
    CHECK(catalog->begin(next, 0, at(7)));
    CHECK(catalog->curve(id).empty());
    CHECK(catalog->find(id)->progress == JobProgress{});
}

TEST_CASE_TEMPLATE("Catalog: who lost the lease changes nothing", Implementation, Sqlite) {
    Implementation place;
    const auto catalog = place.make();
    const std::string id = add(*catalog);
    const Lease lost = claim(*catalog);
    catalog->retry(lost, {}, "", at(2));
    const Lease held = claim(*catalog, 3);
    CHECK(held.epoch > lost.epoch);
    const ModelRecord before = catalog->find(id).value();
    CHECK_FALSE(catalog->renew(lost, at(99)));
    CHECK_FALSE(catalog->begin(lost, 0, at(99)));
    CHECK_FALSE(catalog->report(lost, {"seal", 1, 5, 5, 5.0}, at(99)));
    CHECK_FALSE(catalog->add_rate_point(lost, {5, 5, 5, 5}));
    CHECK_FALSE(catalog->finish(lost, ModelState::done, "", at(99)));
    CHECK_FALSE(catalog->retry(lost, {}, "late", at(99)));
    CHECK_FALSE(catalog->give_back(lost, at(99)));
    const ModelRecord after = catalog->find(id).value();
    CHECK(after.state == ModelState::running);
    CHECK(after.progress == before.progress);
    CHECK(after.updated == before.updated);
    CHECK(catalog->curve(id).empty());
    CHECK(catalog->finish(held, ModelState::done, "", at(100)));
}

TEST_CASE_TEMPLATE("Catalog: a lease that is not renewed in time can be given to another", Implementation, Sqlite) {
    Implementation place;
    const auto catalog = place.make();
    const std::string id = add(*catalog);
    const Lease lease = lease_of(catalog->claim_next(at(0), at(100)).value());
    CHECK(catalog->recover(at(99), {}, "", at(99)) == 0);
    CHECK(catalog->renew(lease, at(200)));
    CHECK(catalog->recover(at(150), {}, "", at(150)) == 0);
    CHECK(catalog->recover(at(200), {}, "", at(200)) == 1);
    CHECK(catalog->find(id)->state == ModelState::queued);
    CHECK_FALSE(catalog->renew(lease, at(300)));
    CHECK(claim(*catalog, 202).epoch > lease.epoch);
}

TEST_CASE_TEMPLATE("Catalog: a finished model stays as it is", Implementation, Sqlite) {
    Implementation place;
    const auto catalog = place.make();
    const std::string id = add(*catalog);
    const Lease lease = claim(*catalog);
    CHECK(catalog->finish(lease, ModelState::failed, "no cameras", at(2)));
    CHECK_FALSE(catalog->finish(lease, ModelState::done, "", at(3)));
    CHECK_FALSE(catalog->retry(lease, {}, "", at(3)));
    CHECK_FALSE(catalog->cancel(id, at(3)));
    CHECK(catalog->recover(Timestamp::max(), {}, "", at(4)) == 0);
    CHECK(catalog->find(id)->state == ModelState::failed);
    CHECK(catalog->find(id)->error == "no cameras");
    CHECK(catalog->find(id)->updated == at(2));
}

TEST_CASE_TEMPLATE("Catalog: a cancelled model is given to nobody, and taken from who has it", Implementation, Sqlite) {
    Implementation place;
    const auto catalog = place.make();
    const std::string queued = add(*catalog);
    CHECK(catalog->cancel(queued, at(1)));
    CHECK_FALSE(catalog->claim_next(at(2)));
    CHECK(catalog->find(queued)->state == ModelState::cancelled);
    const std::string running = add(*catalog);
    const Lease lease = claim(*catalog, 3);
    CHECK(catalog->cancel(running, at(4)));
    CHECK_FALSE(catalog->renew(lease, at(100)));
    CHECK_FALSE(catalog->finish(lease, ModelState::done, "", at(5)));
    CHECK(catalog->find(running)->state == ModelState::cancelled);
    CHECK_FALSE(catalog->cancel(new_model_id(), at(6)));
}

TEST_CASE_TEMPLATE("Catalog: fruitless attempts are limited, what is given back does not count", Implementation,
                   Sqlite) {
    Implementation place;
    const auto catalog = place.make();
    const std::string id = add(*catalog);
    const RetryRule twice{.max_fruitless = 2};
    catalog->give_back(claim(*catalog), at(1));
    CHECK(catalog->find(id)->attempts == 0);
    catalog->retry(claim(*catalog), twice, "died", at(1));
    CHECK(catalog->find(id)->state == ModelState::queued);
    claim(*catalog);
    CHECK(catalog->recover(Timestamp::max(), twice, "died", at(1)) == 1);
    CHECK(catalog->find(id)->state == ModelState::failed);
    CHECK(catalog->find(id)->error == "died");
}

TEST_CASE_TEMPLATE("Catalog: an attempt that took the curve further is not fruitless, one that came as far is",
                   Implementation, Sqlite) {
    Implementation place;
    const auto catalog = place.make();
    const std::string id = add(*catalog);
    const RetryRule twice{.max_fruitless = 2};
    for (std::uint64_t n_bytes : {100, 200, 300, 400}) {
        const Lease lease = claim(*catalog);
        catalog->add_rate_point(lease, {9, n_bytes, 1, 1});
        catalog->retry(lease, twice, "died", at(1));
        CHECK(catalog->find(id)->state == ModelState::queued);
    }
    const Lease lease = claim(*catalog);
    catalog->begin(lease, 0, at(1));
    catalog->add_rate_point(lease, {9, 400, 1, 1});
    catalog->retry(lease, twice, "died", at(1));
    CHECK(catalog->find(id)->state == ModelState::failed);
}

TEST_CASE_TEMPLATE("Catalog: an attempt that is not counted may fail for ever", Implementation, Sqlite) {
    Implementation place;
    const auto catalog = place.make();
    const std::string id = add(*catalog);
    for (int i = 0; i < 20; ++i)
        catalog->retry(claim(*catalog), {.max_fruitless = 2, .is_counted = false}, "no room", at(1));
    CHECK(catalog->find(id)->state == ModelState::queued);
}

TEST_CASE_TEMPLATE("Catalog: a model is not claimed before its time, and holds up no other", Implementation, Sqlite) {
    Implementation place;
    const auto catalog = place.make();
    const std::string early = add(*catalog), late = add(*catalog);
    catalog->retry(claim(*catalog), {.not_before = at(500)}, "", at(1));
    CHECK(catalog->claim_next(at(2))->id == late);
    CHECK_FALSE(catalog->claim_next(at(499)));
    CHECK(catalog->claim_next(at(500))->id == early);
}

TEST_CASE_TEMPLATE("Catalog: a clock that was set back holds up no model", Implementation, Sqlite) {
    Implementation place;
    const auto catalog = place.make();
    const std::string id = add(*catalog);
    constexpr std::int64_t hour = 3'600'000;
    catalog->retry(claim(*catalog), {.not_before = at(2 * hour + 1000)}, "", at(2 * hour));
    CHECK(catalog->claim_next(at(hour))->id == id);
}

TEST_CASE_TEMPLATE("Catalog: models are counted by state, and the final ones found by age", Implementation, Sqlite) {
    Implementation place;
    const auto catalog = place.make();
    const std::string done = add(*catalog), failed = add(*catalog);
    const Lease first = claim(*catalog), second = claim(*catalog);
    catalog->finish(second, ModelState::failed, "", at(20));
    catalog->finish(first, ModelState::done, "", at(10));
    add(*catalog);
    add(*catalog);
    const std::map<ModelState, std::size_t> expected{
        {ModelState::queued, 2}, {ModelState::done, 1}, {ModelState::failed, 1}};
    CHECK(catalog->counts() == expected);
    CHECK(catalog->final_before(at(10)).empty());
    REQUIRE(catalog->final_before(at(11)).size() == 1);
    const auto both = catalog->final_before(at(100));
    REQUIRE(both.size() == 2);
    CHECK(both[0].id == done);
    CHECK(both[1].id == failed);
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
    CHECK(catalog->list(10, Catalog::from_newest).models.size() == 1);
}

TEST_CASE_TEMPLATE("Catalog: pages go from the newest to the oldest", Implementation, Sqlite) {
    Implementation place;
    const auto catalog = place.make();
    const std::string a = add(*catalog), b = add(*catalog), c = add(*catalog);
    const ModelPage first = catalog->list(2, Catalog::from_newest);
    REQUIRE(first.models.size() == 2);
    CHECK(first.models[0].id == c);
    CHECK(first.models[1].id == b);
    CHECK(first.more);
    for (const bool is_gone : {false, true}) {  // the last of the first page, when the second is asked for
        CAPTURE(is_gone);
        if (is_gone) catalog->remove(b);
        const ModelPage second = catalog->list(2, first.models[1].number);
        REQUIRE(second.models.size() == 1);
        CHECK(second.models[0].id == a);
        CHECK_FALSE(second.more);
    }
    CHECK(catalog->list(2, catalog->find(a)->number).models.empty());
}

TEST_CASE_TEMPLATE("Catalog: a removed model's number is given to no other", Implementation, Sqlite) {
    Implementation place;
    const auto catalog = place.make();
    const std::string a = add(*catalog);
    const std::uint64_t number = catalog->find(a)->number;
    catalog->remove(a);
    CHECK(catalog->find(add(*catalog))->number > number);
}

TEST_CASE_TEMPLATE("Catalog: a removed model is forgotten in every state", Implementation, Sqlite) {
    Implementation place;
    const auto catalog = place.make();
    const std::string id = add(*catalog, 0, "key");
    const Lease lease = claim(*catalog);
    CHECK(catalog->remove(id));
    CHECK_FALSE(catalog->remove(id));
    CHECK_FALSE(catalog->report(lease, {}, at(2)));
    CHECK_FALSE(catalog->finish(lease, ModelState::done, "", at(2)));
    CHECK_FALSE(catalog->find(id));
    CHECK(catalog->curve(id).empty());
}
