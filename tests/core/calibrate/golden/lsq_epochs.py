"""weighted_rss_base and rank_base of d016 in linear_identification.csv: the complete base by finite differences of
exact loop closures, the second epoch with three joint zeros of its own and a frame that is turned about O_A and moved.
Run in this folder; needs numpy."""
import csv
import math

import numpy as np

rows=[r for r in csv.DictReader(open('lsq_d016.csv')) if r['set']=='identify']
al=np.radians([270,30,150.]); be=np.radians([30,150,270.]); r0=100.;S0=430.;R0=733.
p0=np.array([v for i in range(3) for v in (al[i],be[i],r0,S0,0,R0)]+[0,0,0])
def forward(p,l,X):
    X=np.array(X,float)
    for _ in range(60):
        f=np.zeros(3);J=np.zeros((3,3))
        for i in range(3):
            a,b,r,S,z,R=p[6*i:6*i+6];h=p[18+i]
            B=(l[i]+z-R)*np.array([math.cos(a),math.sin(a)])+h*np.array([-math.sin(a),math.cos(a)])
            c,s=math.cos(b+X[2]),math.sin(b+X[2])
            D=X[:2]+r*np.array([c,s])-B
            f[i]=D@D-S*S
            J[i]=[2*D[0],2*D[1],2*r*(-D[0]*s+D[1]*c)]
        d=np.linalg.solve(J,-f);X=X+d
        if np.abs(d).max()<1e-14: break
    return X
W=np.array([1/0.010,1/0.010,1/math.radians(0.004)])
tol=np.array([math.radians(.02),math.radians(.02),.05,.05,.05,.05]*3+[.05]*3)
A=[];b=[]
for q in rows:
    l=[float(q['cmd_l%d_mm'%i]) for i in (1,2,3)]
    T=[float(q['target_x_mm']),float(q['target_y_mm']),math.radians(float(q['target_phi_deg']))]
    X=forward(p0,l,T); M=np.array([float(q['x_mm']),float(q['y_mm']),math.radians(float(q['phi_deg']))])
    J=np.zeros((3,27))
    for k in range(21):
        e=np.zeros(21);h=1e-5
        e[k]=h
        J[:,k]=(forward(p0+e,l,X)-forward(p0-e,l,X))/(2*h)
    if int(q['epoch'])>1:
        for i in range(3): J[:,21+i]=J[:,6*i+4]
        J[:,24:]=np.eye(3); J[0,26]=-X[1];J[1,26]=X[0]
    A.append(W[:,None]*J*np.concatenate([tol,[.1]*3,[.1,.1,math.radians(.05)]]));b.append(W*(M-X))
A=np.vstack(A);b=np.concatenate(b)
U,s,V=np.linalg.svd(A,full_matrices=False); rank=(s>1e-6*s[0]).sum()
y=U[:,:rank].T@b
print(len(b), rank, b @ b - y @ y)
