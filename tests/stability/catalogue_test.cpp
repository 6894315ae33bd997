/// The catalogue is complete: every row has a case or a test that exists, every case has a row, and
/// README.md lists them all.
#include "benchmarks/reference/catalogue/catalogue.h"

#include "benchmarks/reference/catalogue/cases.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <set>
#include <sstream>
#include <string>

namespace bullet_ccd::tests
{
using namespace reference;

namespace
{
std::string textOf(const std::string& path)
{
    std::ifstream file(std::string(BULLET_CCD_SOURCES) + "/" + path);
    EXPECT_TRUE(file.good()) << path;
    std::ostringstream text;
    text << file.rdbuf();
    return text.str();
}

/// Ids of all cases.
std::set<std::string> caseIds()
{
    std::set<std::string> ids;
    for (const RigidCase& tested : rigidCases())
    {
        ids.insert(tested.id);
    }
    for (const ArticulatedCase& tested : articulatedCases())
    {
        ids.insert(tested.id);
    }
    return ids;
}

/// "a file: Suite.Name" names a test that the file has.
bool exists(const std::string& tested)
{
    const std::size_t colon = tested.find(": ");
    const std::size_t dot = tested.find('.', colon);
    const std::string suite = tested.substr(colon + 2, dot - colon - 2);
    const std::string text = textOf(tested.substr(0, colon));
    return text.find("(" + suite + ", " + tested.substr(dot + 1) + ")") != std::string::npos;
}

TEST(Catalogue, EveryRowHasACaseOrATestThatExists)
{
    const std::set<std::string> ids = caseIds();
    int properties = 0;
    for (const CatalogueRow& row : catalogueRows())
    {
        SCOPED_TRACE(row.id);
        EXPECT_NE(groupTitle(row.id), "");
        EXPECT_NE(row.title, "");
        EXPECT_EQ(ids.contains(std::string(row.id)), row.tested.empty());
        if (!row.tested.empty() && row.tested != kDeformable)
        {
            EXPECT_TRUE(exists(std::string(row.tested))) << row.tested;
            ++properties;
        }
    }
    EXPECT_GT(properties, 20);
    EXPECT_GE(std::count_if(ids.begin(), ids.end(), [](const auto& id) { return id[0] == 'N'; }),
              15);
}

TEST(Catalogue, EveryCaseHasARow)
{
    for (const std::string& id : caseIds())
    {
        EXPECT_NO_THROW((void)catalogueRow(id)) << id;
    }
}

TEST(Catalogue, RowsAreInOrder)
{
    const auto rows = catalogueRows();
    EXPECT_TRUE(std::is_sorted(rows.begin(),
                               rows.end(),
                               [](const CatalogueRow& a, const CatalogueRow& b)
                               { return a.id < b.id; }));
}

/// `stability_catalogue --list` prints the table.
TEST(Catalogue, TheReadmeListsIt)
{
    EXPECT_NE(textOf("benchmarks/reference/catalogue/README.md").find(catalogueTable()),
              std::string::npos)
        << "replace the table by this one:\n"
        << catalogueTable();
}
}  // namespace
}  // namespace bullet_ccd::tests
