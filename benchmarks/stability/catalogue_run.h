/// Every case through every method, and every relation on the cases that a method gets right.
#pragma once

#include "benchmarks/stability/catalogue_isolated.h"
#include "benchmarks/stability/catalogue_methods.h"

#include <functional>
#include <map>
#include <string>
#include <vector>

namespace bullet_ccd::tests
{
/// What an answer is worth. Only Pass is right.
enum class CaseVerdict
{
    Pass,
    Inaccurate,  ///< early beyond what is promised
    Late,
    Missed,
    FalseContact,
    GaveUp,
    Crashed,
    TimedOut,
    NotApplicable,
};
[[nodiscard]] const char* nameOf(CaseVerdict verdict);

struct JudgedAnswer
{
    CaseVerdict verdict = CaseVerdict::NotApplicable;
    std::string note = {};  ///< why it is not applicable
    double error = 0.0;     ///< of the time, of a contact that was found and is there
    PeerAnswer answer = {};
};

/// Judged by the tolerance of the case, and peers, which are asked for a time, by 1e-4 of the
/// motion if that is more. Late is what is beyond the rounding of the scene, and for peers 1e-9.
[[nodiscard]] JudgedAnswer judge(const IsolatedAnswer& isolated,
                                 const CaseAnswer& exact,
                                 double rounding,
                                 bool isOurs);

struct LostVariant
{
    std::string id;
    std::string variant;
    CaseVerdict verdict = CaseVerdict::Pass;
};

/// Of a method and a relation.
struct RelationCount
{
    int asked = 0;  ///< variants of cases that the method gets right as they are
    int kept = 0;
    double largestShift = 0.0;  ///< of ours: of the time, in parts of the case's window
    std::vector<LostVariant> lost = {};
};

struct CaseRow
{
    std::string id;
    std::string kind;  ///< rigid, articulated
    std::string title;
    CaseAnswer exact = {};
    double rounding = 0.0;                   ///< of a distance [m]
    std::vector<JudgedAnswer> answers = {};  ///< one a method
};

struct MethodRow
{
    std::string name;
    std::string owner;
    std::string setting;
    std::map<std::string, RelationCount> relations = {};  ///< by name
};

struct CatalogueTable
{
    std::string kind;
    std::vector<MethodRow> methods;
    std::vector<CaseRow> cases;
};

struct CatalogueOptions
{
    double limit = 30.0;         ///< seconds for a case
    double variantLimit = 10.0;  ///< and for a variant
    std::string only = {};       ///< one case, by its id
    bool relations = true;
    bool firstVariantOnly = false;
    /// Told before every case: its id, its number from 0 on, how many there are.
    std::function<void(const std::string&, std::size_t, std::size_t)> progress = {};
};

[[nodiscard]] CatalogueTable runRigidCatalogue(const CatalogueOptions& options);
[[nodiscard]] CatalogueTable runArticulatedCatalogue(const CatalogueOptions& options);
}  // namespace bullet_ccd::tests
