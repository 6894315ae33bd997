#include "benchmarks/reference/catalogue/catalogue.h"

#include <algorithm>
#include <fstream>
#include <regex>
#include <stdexcept>

namespace bullet_ccd::reference
{
const std::vector<CatalogueRow>& catalogueRows()
{
    static const std::vector<CatalogueRow> kRows = []
    {
        const std::regex heading("### [A-Z]: (.*)");
        const std::regex row(R"(\| ([A-Z][0-9]+[a-z]?) \| (.*) \| (.*) \|)");
        std::vector<CatalogueRow> rows;
        std::string group;
        std::ifstream file(BULLET_CCD_CATALOGUE);
        for (std::string line; std::getline(file, line);)
        {
            std::smatch parts;
            if (std::regex_match(line, parts, heading))
            {
                group = parts[1];
            }
            else if (std::regex_match(line, parts, row))
            {
                rows.push_back(
                    {.id = parts[1], .group = group, .title = parts[2], .where = parts[3]});
            }
        }
        if (rows.empty())
        {
            throw std::runtime_error(BULLET_CCD_CATALOGUE
                                     " has no rows of the catalogue: keep the sources in place");
        }
        return rows;
    }();
    return kRows;
}

const CatalogueRow& catalogueRow(std::string_view id)
{
    const auto found = std::ranges::find(catalogueRows(), id, &CatalogueRow::id);
    if (found == catalogueRows().end())
    {
        throw std::invalid_argument(BULLET_CCD_CATALOGUE " has no row " + std::string(id) +
                                    ": add it");
    }
    return *found;
}
}  // namespace bullet_ccd::reference
