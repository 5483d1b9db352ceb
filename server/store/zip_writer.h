#pragma once
#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>
#include <string>

namespace anyrate {

/// Writes a zip file without compression, for photographs are compressed already. An object that goes before finish()
/// leaves an incomplete file.
class ZipWriter {
public:
    explicit ZipWriter(const std::filesystem::path& file);  ///< @throws IoError
    ~ZipWriter();
    ZipWriter(const ZipWriter&) = delete;
    ZipWriter& operator=(const ZipWriter&) = delete;

    /// @param name  of the file inside the zip, with "/" between folders @throws IoError
    void add(const std::string& name, std::span<const std::byte> bytes);
    void finish();  ///< @throws IoError

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace anyrate
