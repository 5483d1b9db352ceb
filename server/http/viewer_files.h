#pragma once
#include <filesystem>
#include <map>
#include <memory>
#include <string>

#include "server/http/message.h"

namespace anyrate {

/// The web viewer as web/ built it: a page and what the page loads from this server. Read once, a few MB in memory.
class ViewerFiles {
public:
    /// @param folder  of `npm run viewer` in web/: index.html and assets/*, beside each file perhaps NAME.br and
    /// NAME.gz
    /// @return nullptr if there is no such folder
    /// @throws IoError what is there cannot be read
    static std::shared_ptr<const ViewerFiles> load(const std::filesystem::path& folder);

    /// The page, with a policy that lets it load from this server only. It is the same for every address it has.
    Response page(const Request& request) const;
    /// A file of assets/. Its name changes with its bytes, so it may be kept for ever. @throws HttpProblem 404
    Response asset(const Request& request, const std::string& name) const;

private:
    std::map<std::string, std::string> files_;  ///< by their names in the folder
};

}  // namespace anyrate
