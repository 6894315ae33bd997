#include "tools/grasp_cli/options/contact_options.h"

#include "tools/support/option_values.h"

namespace bullet_ccd::tools
{
void addContactOptions(CLI::App& command, ContactArguments& arguments)
{
    using grasp::ContactModel;
    command
        .add_option("--friction",
                    arguments.friction,
                    "Coulomb's coefficient of friction of all contacts. Default: that of the plan.")
        ->type_name("MU")
        ->check(within(0.0, 10.0))
        ->group("Contacts");
    command
        .add_option("--model",
                    arguments.model,
                    "What a contact passes on. hard: a force within the friction cone. soft: a "
                    "torsional moment, "
                    "too. frictionless: a normal force.")
        ->type_name("MODEL")
        ->transform(wordFor<ContactModel>({{"hard", ContactModel::HardFinger},
                                           {"soft", ContactModel::SoftFinger},
                                           {"frictionless", ContactModel::Frictionless}}))
        ->default_str("hard")
        ->group("Contacts");
    command
        .add_option(
            "--torsion",
            arguments.torsion,
            "With --model soft: the largest torsional moment over the largest friction force [m].")
        ->type_name("M")
        ->check(within(0.0, 1.0))
        ->capture_default_str()
        ->group("Contacts");
}

grasp::ContactLaw contactLaw(const ContactArguments& arguments, const grasp::PlannerOptions& plan)
{
    return {.model = arguments.model,
            .friction = arguments.friction.value_or(plan.friction),
            .torsion = arguments.torsion};
}
}  // namespace bullet_ccd::tools
