"""The stability of grasps and of simulated hands as a section of a page and as pictures.

    section(measured)   HTML <section> of one family, "grasps" or "simulation", as the programs
                        stability_grasps and stability_simulation write it
    pictures(measured)  {name: SVG} of the same charts, each a file of its own

What the text says of a chart is computed from the data, where ours is worse, too.
"""
import stability_grasp_charts as grasps
import stability_world_charts as simulation


def section(measured):
    """HTML of a family; raises KeyError for one that is not known."""
    return {"grasps": grasps.grasps_section,
            "simulation": simulation.simulation_section}[measured["family"]](measured)


def pictures(measured):
    """SVG documents by name, of a family; those that would show nothing are left out."""
    draws = {"grasps": {"grasps_noise": grasps.noise_picture, "grasps_meshes": grasps.mesh_picture},
             "simulation": {"simulation_outcomes": simulation.outcome_picture,
                            "simulation_drift": simulation.drift_picture,
                            "simulation_depth": simulation.depth_picture,
                            "simulation_energy": simulation.energy_picture,
                            "simulation_time": simulation.time_picture}}[measured["family"]]
    drawn = {name: draw(measured) for name, draw in draws.items()}
    return {name: picture for name, picture in drawn.items() if picture}
