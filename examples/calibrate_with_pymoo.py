"""The paper's operators in pymoo's own genetic algorithm, on the calibration of a simulated scanner."""

from pymoo.algorithms.soo.nonconvex.ga import GA
from pymoo.optimize import minimize

from robolaser import Plan, calibrate, find_robot
from robolaser.operators import ArithmeticCrossover, NonUniformMutation
from robolaser.problems import ScannerCalibration
from robolaser.simulation import paper

cell = paper(find_robot("scorbot_er7"), seed=1)  # 5 points in each of 5 poses, as in the paper
problem = ScannerCalibration(cell.dataset)
rows = len(cell.dataset.points)


def rms_mm(objective_m2: float) -> float:
    return 1e3 * (objective_m2 / rows) ** 0.5


algorithm = GA(pop_size=100, crossover=ArithmeticCrossover(prob=0.85), mutation=NonUniformMutation(prob_var=0.1, b=5))
result = minimize(problem, algorithm, ("n_gen", 100), seed=1)
print(f"genetic algorithm, 100 generations: {rms_mm(result.F[0]):.2f} mm")
for name, value in zip(problem.names, result.X, strict=True):
    print(f"  {name:<6} {value:12.6g}   true {cell.truth[name]:12.6g}")

polished = calibrate(cell.dataset, Plan(generations=60))
print(f"search and polish: {rms_mm(polished.objective_m2):.2f} mm")
