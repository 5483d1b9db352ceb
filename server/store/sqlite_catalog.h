#pragma once
#include <filesystem>
#include <memory>

#include "server/store/catalog.h"

namespace anyrate {

/// The catalog of one machine: an SQLite file in write-ahead mode, every transaction on the disk before it returns.
class SqliteCatalog final : public Catalog {
public:
    /// Opens `file`, or makes it. @throws IoError it cannot be opened @throws InputError it was written by a newer
    /// version
    explicit SqliteCatalog(const std::filesystem::path& file);
    ~SqliteCatalog() override;

    Added add(const NewModel& model, Timestamp now) override;
    std::optional<ModelRecord> find(const std::string& id) override;
    ModelPage list(std::size_t limit, std::uint64_t before) override;
    std::vector<RatePoint> curve(const std::string& id) override;
    bool remove(const std::string& id) override;
    bool cancel(const std::string& id, Timestamp now) override;
    std::map<ModelState, std::size_t> counts() override;
    std::vector<ModelRecord> final_before(Timestamp before) override;
    std::optional<ModelRecord> claim_next(Timestamp now, Timestamp lease_until = Timestamp::max()) override;
    bool renew(const Lease& lease, Timestamp lease_until) override;
    bool begin(const Lease& lease, std::uint64_t n_bytes, Timestamp now) override;
    bool report(const Lease& lease, const JobProgress& progress, Timestamp now) override;
    bool add_rate_point(const Lease& lease, const RatePoint& point) override;
    bool finish(const Lease& lease, ModelState state, const std::string& error, Timestamp now) override;
    bool retry(const Lease& lease, const RetryRule& rule, const std::string& error, Timestamp now) override;
    bool give_back(const Lease& lease, Timestamp now) override;
    int recover(Timestamp end, const RetryRule& rule, const std::string& error, Timestamp now) override;

    /// Copies the catalog as it stands at one moment to a new file, while others use it. @throws IoError
    void back_up(const std::filesystem::path& file);

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace anyrate
