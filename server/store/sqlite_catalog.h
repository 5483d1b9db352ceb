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
    ModelPage list(std::size_t limit, const std::string& after) override;
    std::vector<RatePoint> curve(const std::string& id) override;
    bool remove(const std::string& id) override;
    std::optional<ModelRecord> claim_next(Timestamp now) override;
    void report(const std::string& id, const JobProgress& progress, Timestamp now) override;
    void add_rate_point(const std::string& id, const RatePoint& point) override;
    void finish(const std::string& id, ModelState state, const std::string& error, Timestamp now) override;
    void retry(const std::string& id, int max_attempts, const std::string& error, Timestamp now) override;
    void give_back(const std::string& id, Timestamp now) override;
    int recover(int max_attempts, const std::string& error, Timestamp now) override;

private:
    struct Database;
    std::unique_ptr<Database> database_;
};

}  // namespace anyrate
